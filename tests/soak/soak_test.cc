// A long run of a small body with random edits of everything. Nothing may crash, become NaN, use more
// and more memory, or open the balance of energy and momentum.
//
// TETRACTION_SOAK_STEPS (default 1,000,000), TETRACTION_SOAK_SECONDS (600) and TETRACTION_SOAK_SEED
// (20061): the test ends when both so many steps and so many seconds are over.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tetraction/core/error.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/simulation/session.h"

namespace tetraction {
namespace {

double setting(const char* name, double otherwise) {
  const char* text = std::getenv(name);
  return text != nullptr ? std::atof(text) : otherwise;
}

// Memory of this process that is in use, in bytes.
double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  double pages = 0.0;
  file >> pages >> pages;
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE));
}

// The same numbers with every standard library.
class Random {
 public:
  explicit Random(unsigned seed) : numbers_(seed) {}
  int below(int end) { return static_cast<int>(numbers_() % static_cast<unsigned>(end)); }
  bool one_in(int n) { return below(n) == 0; }
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(numbers_()) / 4294967295.0;
  }
  // Equally likely in each power of ten.
  double magnitude(double low, double high) { return low * std::pow(high / low, between(0, 1)); }
  Vector3 vector(double size) {
    // One after the other: the order of function arguments is not defined.
    const double x = between(-size, size);
    const double y = between(-size, size);
    return {x, y, between(-size, size)};
  }
  template <class List>
  auto of(const List& list) {
    return *(std::begin(list) + below(static_cast<int>(std::size(list))));
  }

 private:
  std::mt19937 numbers_;
};

constexpr double kYoung = 1e5;  // Pa
constexpr double kPoisson = 0.3;
constexpr double kSize = 1.0;  // m

// A block of 2 × 1 × 1 cells, free, which falls and turns a little.
Scene soaked_scene() {
  Scene scene;
  scene.mesh.generate =
      GeneratorSettings{GeneratorKind::kBox, {2.0 * kSize, kSize, kSize}, {2, 1, 1}};
  scene.material.youngs_modulus = kYoung;
  scene.material.poissons_ratio = kPoisson;
  MaterialRegionSettings half;
  half.select = SelectBox{{-1.0, -1.0, -1.0}, {kSize, 2.0 * kSize, 2.0 * kSize}};
  half.material = scene.material;
  scene.material_region.push_back(half);
  scene.time = {Integrator::kVerlet, 5e-3, false, 1e6};
  scene.initial.angular_velocity = {0.1, 0.2, 0.05};
  AmplitudeSettings sine;
  sine.name = "sine";
  sine.kind = AmplitudeKind::kSine;
  scene.amplitude.push_back(sine);
  return scene;
}

// Makes edits of every kind. They are such that most of them are accepted and few runs blow up.
class RandomEdits {
 public:
  RandomEdits(Random& random, Index vertices) : random_(random), vertices_(vertices) {}

  // Any edit of a run that has so many constraints, and so many loads of each kind.
  Edit any(std::size_t constraints, std::size_t fixes, const LoadLists& loads) {
    switch (random_.below(16)) {
      case 0:
        return material();
      case 1:
      case 2:
      case 3:
        return time();
      case 4:
        return solver();
      case 5:
        return damping();
      case 6:
        return environment();
      case 7:
      case 8:
        return load(loads);
      case 9:
        return SetFix{present(fixes), fix()};
      case 10:
      case 11:
        return release(fixes);
      case 12:
        return SetConstraint{present(constraints), constraint()};
      case 13:
        return RemoveConstraint{constraints == 0 ? 0 : number_below(constraints)};
      case 14:
        return SetMomentum{{selection(), random_.vector(5.0), {}}};
      default:
        return shift();
    }
  }

  // Steps with which nearly everything goes well.
  Edit calm_time() { return SetTime{{Integrator::kBackwardEuler, 1e-3, false, 1e6}}; }
  Edit calm_damping() { return SetDamping{{0.0, 5.0, 50.0}}; }

  SetTime time() {
    constexpr std::array kAll = {Integrator::kExplicit, Integrator::kVerlet, Integrator::kMidpoint,
                                 Integrator::kBackwardEuler, Integrator::kEnergyMomentum};
    TimeSettings time{random_.of(kAll), random_.magnitude(2e-4, 4e-3), false, 1e6};
    const bool is_explicit =
        time.integrator == Integrator::kExplicit || time.integrator == Integrator::kVerlet;
    time.automatic = is_explicit && random_.one_in(4);
    if (!time.automatic && random_.one_in(4)) time.retry = 1 + random_.below(5);
    if (!time.automatic && time.retry == 0 && random_.one_in(6)) {
      time.adapt = StepAdaptation::kError;
      time.tolerance = random_.magnitude(1e-5, 1e-2);
      time.max_step = 5e-3;
    }
    return {time};
  }

 private:
  std::size_t number_below(std::size_t count) {
    return static_cast<std::size_t>(random_.below(static_cast<int>(count)));
  }
  // One of those that there are, or none: then it is a new one.
  std::optional<std::size_t> present(std::size_t count) {
    if (count == 0 || (count < kMost && random_.one_in(3))) return std::nullopt;
    return number_below(count);
  }

  SetMaterial material() {
    const std::vector<MaterialChoice>& choices = material_choices();
    MaterialSettings material;
    const double young = random_.magnitude(0.2 * kYoung, 2.0 * kYoung);
    material.model = random_.of(choices).name;
    material.youngs_modulus = young;
    material.poissons_ratio = random_.between(0.0, 0.45);
    if (material.model == "mooney-rivlin") material.numbers["ratio"] = random_.between(0.1, 0.9);
    if (material.model == "yeoh") {
      material.numbers["c20"] = 0.01 * young;
      material.numbers["c30"] = 0.001 * young;
    }
    const MaterialChoice& choice = *find_material(material.model);
    const auto is_missing = [&](const MaterialParameter& p) {
      return !number_of(material, p.name).has_value();
    };
    if (std::any_of(choice.instead.begin(), choice.instead.end(), is_missing)) {
      choice.set_like(material, lame_from_young(young, *material.poissons_ratio));
    }
    return {random_.below(2), material};
  }
  SetSolver solver() {
    SolverSettings solver;
    solver.linear = random_.of(std::array{LinearSolver::kAuto, LinearSolver::kMatrixFree,
                                          LinearSolver::kCg, LinearSolver::kFactor});
    if (random_.one_in(5)) solver = {"ceres", LinearSolver::kAuto};
    solver.tolerance = random_.magnitude(1e-11, 1e-8);
    return {solver};
  }
  SetDamping damping() {
    const auto some = [this](double most) {
      return random_.one_in(2) ? 0.0 : random_.between(0.0, most);
    };
    const double drag = some(2.0);
    const double mass_damping = some(1.0);
    return {{drag, mass_damping, some(50.0)}};
  }
  SetEnvironment environment() {
    EnvironmentSettings environment;
    environment.kind = random_.of(std::array{EnvironmentKind::kNone, EnvironmentKind::kGravity,
                                             EnvironmentKind::kAttraction});
    environment.strength = random_.between(0.0, 3.0);
    environment.direction = unit_direction(random_.vector(1.0) + Vector3(0.0, -2.0, 0.0));
    environment.softening = 1.0;
    if (random_.one_in(4)) environment.amplitude = "sine";
    return {environment};
  }
  Selection selection() {
    switch (random_.below(6)) {
      case 0:
        return SelectAll{};
      case 1:
        return SelectPlane{0, random_.one_in(2) ? 0.0 : 2.0 * kSize, {}};
      case 2:
        return SelectSphere{{0.0, 0.0, 0.0}, random_.between(0.1, 1.5)};
      case 3:
        return SelectFaces{Vector3::UnitY(), 30.0};
      case 4:
        return SelectNearest{random_.vector(2.0)};
      default:
        return SelectVertices{{random_.below(static_cast<int>(vertices_))}};
    }
  }
  SetForce load(const LoadLists& loads) {
    ForceSettings load;
    load.kind = random_.of(values_of<LoadKind>());
    const std::optional<std::size_t> index = present(loads.list(load.kind).size());
    load.select = selection();
    load.vector = random_.vector(load.kind == LoadKind::kTraction ? 200.0 : 20.0);
    if (load.kind == LoadKind::kPressure) load.value = random_.between(-200.0, 200.0);
    if (load.kind == LoadKind::kBodyForce) load.vector *= 50.0;
    if (random_.one_in(4)) load.amplitude = "sine";
    return {index, load};
  }
  FixSettings fix() {
    FixSettings fix;
    fix.select = selection();
    for (bool& fixed : fix.components) fixed = !random_.one_in(4);
    switch (random_.below(4)) {
      case 0:
        fix.offset = random_.vector(0.01);
        break;
      case 1:
        fix.velocity = random_.vector(0.1);
        break;
      default:
        break;
    }
    if (random_.one_in(4)) {
      fix.is_penalty = true;
      fix.penalty = random_.magnitude(1e2, 1e4);
    }
    return fix;
  }
  Unfix release(std::size_t fixes) {
    if (fixes > 0 && random_.one_in(2)) return {SelectAll{}, {}, number_below(fixes)};
    return {random_.one_in(2) ? Selection(SelectAll{}) : selection(), {}, std::nullopt};
  }
  ConstraintSettings constraint() {
    ConstraintSettings constraint;
    constraint.kind = random_.of(std::array{ConstraintKind::kDistance, ConstraintKind::kPlane,
                                            ConstraintKind::kLine, ConstraintKind::kRigid});
    const int first = random_.below(static_cast<int>(vertices_));
    const int step = 1 + random_.below(static_cast<int>(vertices_) - 1);
    constraint.vertices = {first, (first + step) % vertices_};
    constraint.select = selection();
    constraint.direction = unit_direction(random_.vector(1.0) + Vector3(0.0, 2.0, 0.0));
    if (constraint.kind == ConstraintKind::kRigid && random_.one_in(2)) {
      constraint.velocity = random_.vector(0.1);
      constraint.angular_velocity = random_.vector(0.5);
    }
    return constraint;
  }
  ShiftState shift() {
    ShiftSettings shift;
    shift.vertices = {random_.below(static_cast<int>(vertices_))};
    shift.displacement = {random_.vector(0.005)};
    shift.impulse = {random_.vector(0.5)};
    return {shift};
  }

  static constexpr std::size_t kMost = 6;  // of a kind, so that the steps do not become slower
  Random& random_;
  Index vertices_;
};

// The events of the test, for the report at the end.
struct Counts {
  std::int64_t steps = 0;
  std::int64_t edits = 0;
  std::int64_t refused = 0;
  std::int64_t failures = 0;
  std::int64_t restored = 0;
  std::int64_t bodies = 0;
  double largest_linear_drift = 0.0;
  double largest_jump = 0.0;         // of the energy error in an edit
  double largest_exact_error = 0.0;  // energy error of a step that should have none
};

double relative(double difference, double scale) {
  return scale > 0.0 ? std::abs(difference) / scale : std::abs(difference);
}

// The energies and momenta of the balance against those of the state itself, and the balance.
void expect_closed_balance(const Session& session, Counts& counts) {
  const State& state = session.state();
  const Balance& balance = session.balance();
  ASSERT_TRUE(state.position.allFinite() && state.momentum.allFinite());
  const Vector& masses = session.system().mass();
  double kinetic = 0.0;
  double momenta = 0.0;
  Vector3 linear = Vector3::Zero();
  for (Index i = 0; i < masses.size(); ++i) {
    const Vector3 p = state.momentum.segment<3>(3 * i);
    kinetic += 0.5 * p.squaredNorm() / masses[i];
    linear += p;
    momenta += p.norm();
  }
  EXPECT_LE(relative(kinetic - balance.energies().kinetic(), kinetic), 1e-9);
  EXPECT_LE((linear - balance.momenta().linear).norm(), 1e-12 * momenta + 1e-300);
  for (const double value :
       {balance.energy_error(), balance.external_work(), balance.dissipated_energy(),
        balance.constraint_work(), balance.edit_work(), balance.angular_momentum_drift()}) {
    ASSERT_TRUE(std::isfinite(value));
  }
  // Dissipated energy is never given back.
  EXPECT_GE(balance.dissipated_energy(), -1e-9 * balance.energy_scale());
  counts.largest_linear_drift =
      std::max(counts.largest_linear_drift, balance.linear_momentum_drift());
  EXPECT_LE(balance.linear_momentum_drift(), 1e-6);
}

class Soak : public testing::Test {
 protected:
  bool is_over() const {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
    return static_cast<double>(counts_.steps) >= wanted_steps_ &&
           elapsed.count() >= wanted_seconds_;
  }

  // A body from its start on, for so many steps.
  void soak_body(std::int64_t steps) {
    const Scene scene = soaked_scene();
    TetMesh mesh = generate_mesh(*scene.mesh.generate);
    RandomEdits edits(random_, mesh.vertex_count());
    auto session = std::make_unique<Session>(scene, std::move(mesh));
    session->keep_good_states();
    ++counts_.bodies;
    int failures = 0;
    for (std::int64_t i = 0; i < steps && failures < 20; ++i) {
      if (random_.one_in(30)) {
        apply(*session,
              edits.any(session->constraints().size(), session->fix_count(), session->loads()));
      }
      if (random_.one_in(2000)) {
        session->restore(session->checkpoint());
        ++counts_.restored;
      }
      const double error = session->balance().energy_error();
      if (session->step()) {
        ++counts_.steps;
        expect_energy_kept(*session, error);
      } else {
        ASSERT_NE(session->message(), "");
        ++counts_.failures;
        ++failures;
        session->go_back();
        apply(*session, edits.calm_time());
        apply(*session, edits.calm_damping());
        apply(*session, Unfix{});
        apply(*session, SetEnvironment{});
      }
      if (i % 1000 == 999) {
        expect_closed_balance(*session, counts_);
        if (HasFailure()) return;
      }
    }
  }

  // A step of energy-momentum keeps the energy to the tolerance of its equations.
  void expect_energy_kept(const Session& session, double error_before) {
    const Balance& balance = session.balance();
    const TimeSettings& time = session.time_settings();
    if (time.integrator != Integrator::kEnergyMomentum) return;
    const double error = std::abs(balance.energy_error() - error_before) / balance.energy_scale();
    counts_.largest_exact_error = std::max(counts_.largest_exact_error, error);
    EXPECT_LE(error, 1e-10);
  }

  // Whatever an edit does to the energy is its work, and no error.
  void apply(Session& session, const Edit& edit) {
    const double error = session.balance().energy_error();
    try {
      session.apply(edit);
      ++counts_.edits;
      const double jump = std::abs(session.balance().energy_error() - error);
      counts_.largest_jump =
          std::max(counts_.largest_jump, jump / session.balance().energy_scale());
      EXPECT_LE(jump, 1e-9 * session.balance().energy_scale()) << edit.index();
    } catch (const InputError& refusal) {
      ASSERT_NE(std::string(refusal.what()), "");
      ++counts_.refused;
    }
  }

  const unsigned seed_ = static_cast<unsigned>(setting("TETRACTION_SOAK_SEED", 20061));
  const double wanted_steps_ = setting("TETRACTION_SOAK_STEPS", 1e6);
  const double wanted_seconds_ = setting("TETRACTION_SOAK_SECONDS", 600.0);
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  Random random_{seed_};
  Counts counts_;
};

TEST_F(Soak, RandomEditsOfEverything) {
  std::printf("seed %u\n", seed_);
  std::vector<double> memory;
  while (!is_over() && !HasFailure()) {
    soak_body(std::min<std::int64_t>(20'000, static_cast<std::int64_t>(wanted_steps_) / 4));
    memory.push_back(resident_bytes());
    std::printf("%lld steps, %.1f MB\n", static_cast<long long>(counts_.steps),
                memory.back() * 1e-6);
    std::fflush(stdout);
  }
  std::printf(
      "%lld steps of %lld bodies, %lld edits and %lld that were refused, %lld failures, %lld "
      "checkpoints restored; largest drift of the linear momentum %.2g, energy error of an edit "
      "%.2g and of a step of energy-momentum %.2g\n",
      static_cast<long long>(counts_.steps), static_cast<long long>(counts_.bodies),
      static_cast<long long>(counts_.edits), static_cast<long long>(counts_.refused),
      static_cast<long long>(counts_.failures), static_cast<long long>(counts_.restored),
      counts_.largest_linear_drift, counts_.largest_jump, counts_.largest_exact_error);
  EXPECT_GT(counts_.edits, 2 * counts_.refused);
  EXPECT_LT(counts_.failures, counts_.steps / 100);
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return;  // sanitizers keep memory that was freed
#endif
  // The allocator and the thread pool take their memory once, in the first quarter.
  const std::size_t settled = memory.size() / 4;
  EXPECT_LE(memory.back(), memory[settled] + 16e6) << "The memory in use grows.";
}

}  // namespace
}  // namespace tetraction
