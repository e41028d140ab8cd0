#include "tetraction/io/text_file.h"

#include "output_file.h"

namespace tetraction {

void write_text_file(const std::string& path, const std::string& text) {
  ReplacementFile file(path);
  file.write(text);
  file.finish();
}

}  // namespace tetraction
