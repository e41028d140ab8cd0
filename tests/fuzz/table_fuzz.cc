// Tables of numbers: amplitudes and initial fields.
#include "fuzz_target.h"
#include "io/text/csv_table.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/mesh/generate.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tetraction;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::string path = fuzzing::written("table.csv", text);
  if (!fuzzing::accepted([&] { read_csv(path); })) return 0;
  InitialSettings initial;
  initial.velocity_field.file = path;
  TetMesh mesh = generate_tetrahedron();
  fuzzing::accepted([&] { add_initial_fields(initial, mesh); });
  return 0;
}
