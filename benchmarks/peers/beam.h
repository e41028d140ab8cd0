// The beam of beam.py for programs in C++: reads its file, and prints what a program measured.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace peers {

struct Beam {
  double youngs_modulus = 0.0;  ///< Pa
  double poissons_ratio = 0.0;
  double density = 0.0;  ///< kg/m³
  double gravity = 0.0;  ///< m/s², along −y
  double step = 0.0;     ///< s
  double tolerance = 0.0;
  int steps = 0;
  std::vector<double> vertices;          ///< three coordinates each, m
  std::vector<std::int32_t> tetrahedra;  ///< four vertices each
  std::vector<std::int32_t> held;        ///< the vertices in the wall
  std::vector<std::int32_t> tip;         ///< the vertices of the free end

  /// The shear modulus μ and Lamé's λ, Pa.
  double mu() const { return youngs_modulus / (2.0 * (1.0 + poissons_ratio)); }
  double lambda() const {
    return youngs_modulus * poissons_ratio /
           ((1.0 + poissons_ratio) * (1.0 - 2.0 * poissons_ratio));
  }
};

/// What a program measured.
struct Report {
  std::string program;
  std::string version;
  std::string solver;           ///< of the linear systems
  std::vector<double> seconds;  ///< of each step
  long newton = 0;              ///< iterations in all steps
  long iterations = 0;          ///< of conjugate gradients, in all steps
  long bytes = 0;               ///< the growth of the peak of the resident memory since the start
  double tip = 0.0;  ///< mean displacement of the free end along y after the last step, m
};

/// Seconds since some moment.
inline double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The largest resident memory of the process so far, bytes. That of getrusage() would begin with the
/// memory of the process that started this one.
inline long peak_bytes() {
  std::ifstream file("/proc/self/status");
  std::string name;
  long kibibytes = 0;
  while (file >> name) {
    if (name == "VmHWM:") {
      file >> kibibytes;
      break;
    }
  }
  return 1024 * kibibytes;
}

template <class Value>
void read_rows(std::ifstream& file, std::size_t columns, std::vector<Value>& values) {
  std::size_t rows = 0;
  file >> rows;
  values.resize(columns * rows);
  for (Value& value : values) file >> value;
}

/// Throws std::runtime_error if the file cannot be read or has an unknown name.
inline Beam read_beam(const std::string& path) {
  std::ifstream file(path);
  Beam beam;
  std::string name;
  while (file >> name) {
    if (name == "youngs_modulus") {
      file >> beam.youngs_modulus;
    } else if (name == "poissons_ratio") {
      file >> beam.poissons_ratio;
    } else if (name == "density") {
      file >> beam.density;
    } else if (name == "gravity") {
      file >> beam.gravity;
    } else if (name == "step") {
      file >> beam.step;
    } else if (name == "tolerance") {
      file >> beam.tolerance;
    } else if (name == "steps") {
      file >> beam.steps;
    } else if (name == "vertices") {
      read_rows(file, 3, beam.vertices);
    } else if (name == "tetrahedra") {
      read_rows(file, 4, beam.tetrahedra);
    } else if (name == "held") {
      read_rows(file, 1, beam.held);
    } else if (name == "tip") {
      read_rows(file, 1, beam.tip);
    } else {
      throw std::runtime_error(path + ": the name " + name + " is not known.");
    }
    if (!file) throw std::runtime_error(path + ": a number of " + name + " cannot be read.");
  }
  if (beam.tetrahedra.empty()) throw std::runtime_error(path + " cannot be read or has no body.");
  return beam;
}

/// One line of JSON.
inline void print(const Report& report) {
  std::printf("{\"program\": \"%s\", \"version\": \"%s\", \"solver\": \"%s\", \"seconds\": [",
              report.program.c_str(), report.version.c_str(), report.solver.c_str());
  for (std::size_t k = 0; k < report.seconds.size(); ++k) {
    std::printf("%s%.9g", k == 0 ? "" : ", ", report.seconds[k]);
  }
  std::printf("], \"newton\": %ld, \"iterations\": %ld, \"bytes\": %ld, \"tip\": %.15g}\n",
              report.newton, report.iterations, report.bytes, report.tip);
}

}  // namespace peers
