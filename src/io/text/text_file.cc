#include "tetraction/io/text_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "tetraction/core/error.h"

namespace tetraction {

void write_text_file(const std::string& path, const std::string& text) {
  const std::string temporary = path + ".part";
  const auto fail = [&] {
    const std::string reason = std::strerror(errno);
    std::remove(temporary.c_str());
    throw OutputError(
        fmt::format("{}: cannot be written ({}). Check the directory's permissions "
                    "and the free space.",
                    path, reason));
  };
  {
    std::ofstream file(temporary, std::ios::binary);
    if (!file) fail();
    file << text;
    file.close();
    if (!file) fail();
  }
  if (std::rename(temporary.c_str(), path.c_str()) != 0) fail();
}

}  // namespace tetraction
