#include "guarded_grid.h"

#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridReader.h>

#include <sys/mman.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

#include "core/quoting.h"
#include "guarded_process.h"
#include "io/text/byte_stream.h"
#include "io/text/text_scanner.h"
#include "quiet_vtk.h"
#include "strict_xml_reader.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

constexpr const char* kNotThat = "the file cannot be read as a VTK unstructured grid";

// The bytes of a file in a file of memory: VTK reads what has been checked, also if the file is replaced
// meanwhile.
class FileInMemory {
 public:
  FileInMemory(const std::string& path, std::string_view bytes)
      : descriptor_(memfd_create("mesh", MFD_CLOEXEC)) {
    bool good = descriptor_ >= 0;
    while (good && !bytes.empty()) {
      const ssize_t count = write(descriptor_, bytes.data(), bytes.size());
      if (count < 0 && errno == EINTR) continue;
      good = count > 0;
      if (good) bytes.remove_prefix(static_cast<std::size_t>(count));
    }
    if (good) return;
    const std::string reason = std::strerror(errno);
    if (descriptor_ >= 0) close(descriptor_);
    throw FileError(fmt::format("{}: cannot be read ({}).", path, reason));
  }
  ~FileInMemory() { close(descriptor_); }
  FileInMemory(const FileInMemory&) = delete;
  FileInMemory& operator=(const FileInMemory&) = delete;

  /// Also for a child process, but no other.
  std::string path() const { return fmt::format("/proc/self/fd/{}", descriptor_); }

 private:
  int descriptor_;
};

vtkSmartPointer<vtkUnstructuredGrid> read_grid(const std::string& path, bool xml) {
  VtkMessages messages;
  vtkNew<StrictXmlReader> xml_reader;
  vtkNew<vtkUnstructuredGridReader> legacy_reader;
  vtkSmartPointer<vtkUnstructuredGrid> grid;
  if (xml) {
    messages.watch(xml_reader);
    xml_reader->SetFileName(path.c_str());
    xml_reader->Update();
    if (!xml_reader->trouble().empty()) throw FileError(xml_reader->trouble());
    grid = xml_reader->GetOutput();
  } else {
    messages.watch(legacy_reader);
    legacy_reader->SetFileName(path.c_str());
    legacy_reader->ReadAllScalarsOn();
    legacy_reader->ReadAllVectorsOn();
    legacy_reader->ReadAllTensorsOn();
    legacy_reader->ReadAllNormalsOn();
    legacy_reader->ReadAllTCoordsOn();
    legacy_reader->ReadAllColorScalarsOn();
    legacy_reader->ReadAllFieldsOn();
    legacy_reader->Update();
    grid = legacy_reader->GetOutput();
  }
  if (!messages.empty()) throw FileError("VTK: " + excerpt(messages.first(), 300));
  return grid;
}

// An error's text, empty if there is none, and the bytes.
std::string read_in_child(const std::string& path, bool xml, const VtkHeader& header,
                          const std::function<std::string(vtkUnstructuredGrid*)>& encode) {
  // Threads of the parent do not exist here; a pool that waits for them would hang.
  setenv("VTK_SMP_BACKEND_IN_USE", "Sequential", 1);
  ByteWriter out;
  try {
    const auto grid = read_grid(path, xml);
    if (header.own_arrays && (grid->GetPointData()->GetArray("vertex_id") == nullptr ||
                              grid->GetCellData()->GetArray("element_id") == nullptr ||
                              grid->GetCellData()->GetArray("region") == nullptr)) {
      throw FileError("it lacks the data that its title announces");
    }
    std::string bytes = encode(grid);
    out.put_text("");
    return bytes.insert(0, out.bytes());
  } catch (const FileError& error) {
    out.put_text(error.what());
    return out.bytes();
  }
}

}  // namespace

GridFile read_guarded(const std::string& path,
                      const std::function<std::string(vtkUnstructuredGrid*)>& encode) {
  const std::string extension = std::filesystem::path(path).extension().string();
  const bool xml = extension.size() == 4 && std::tolower(extension.back()) == 'u';
  GridFile file;
  std::string text = read_file(path);
  file.header = xml ? check_xml_header(path, text) : check_legacy_header(path, text);
  const std::size_t size = text.size();
  const FileInMemory copy(path, text);
  std::string().swap(text);
  GuardLimits limits;
  // A compressed file may hold much more than its size.
  const double items = static_cast<double>(file.header.points + file.header.cells);
  limits.processor_seconds = 2.0 + static_cast<double>(size) / 2e6 + items / 2e5;
  limits.seconds = 20.0 + 2.0 * limits.processor_seconds;
  limits.memory = (std::size_t{1} << 30) + 100 * size;
  GuardResult result =
      run_guarded([&] { return read_in_child(copy.path(), xml, file.header, encode); }, limits);
  if (!result.finished) {
    throw FileError(fmt::format("{}: {}: VTK's reader {} on it. The file is broken; write it anew.",
                                path, kNotThat, result.failure));
  }
  ByteReader in(result.bytes);
  const std::string error = in.get_text();
  if (!in.good()) refuse_grid(path, "its parts do not fit together");
  if (!error.empty()) refuse_grid(path, error);
  result.bytes.erase(0, sizeof(std::uint64_t));
  file.bytes = std::move(result.bytes);
  return file;
}

void refuse_grid(const std::string& path, const std::string& what) {
  throw FileError(fmt::format("{}: {}: {}.", path, kNotThat, what));
}

void check_counts(const std::string& path, const VtkHeader& announced, std::size_t points,
                  std::size_t cells) {
  const auto check = [&](const char* what, std::int64_t wanted, std::size_t found) {
    if (wanted == static_cast<std::int64_t>(found)) return;
    refuse_grid(path, fmt::format("it announces {} {} and holds {}", wanted, what, found));
  };
  check("points", announced.points, points);
  check("cells", announced.cells, cells);
}

}  // namespace tetraction
