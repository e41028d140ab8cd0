// Calls a fuzz target with every file of its corpus and with mutations of them. The random numbers
// have a fixed seed, so that every run is the same.
//
//     fuzz_TARGET CORPUS MUTATIONS [SEED [SLOWEST]]
//
// writes the input that took longest to the file SLOWEST.
#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "fuzz_target.h"

namespace {

// Numbers at which readers go wrong.
constexpr std::array kNumbers{"-1",
                              "0",
                              "1",
                              "nan",
                              "inf",
                              "1e400",
                              "2147483648",
                              "4294967295",
                              "-2147483649",
                              "3.5",
                              "1e-320",
                              "",
                              "9223372036854775807",
                              "18446744073709551616"};

class Mutator {
 public:
  Mutator(const std::vector<std::string>& corpus, unsigned seed) : corpus_(corpus), random_(seed) {}

  std::string next() {
    std::string text = corpus_[below(corpus_.size())];
    const std::size_t changes = 1 + below(4);
    for (std::size_t i = 0; i < changes; ++i) change(text);
    return text;
  }

 private:
  // Division keeps the numbers the same with every standard library.
  std::size_t below(std::size_t count) { return count == 0 ? 0 : random_() % count; }

  void change(std::string& text) {
    const std::size_t at = below(text.size() + 1);
    const std::size_t length = std::min(text.size() - at, 1 + below(1U << below(8)));
    switch (below(8)) {
      case 0:
        if (at < text.size()) text[at] = static_cast<char>(below(256));
        return;
      case 1:
        if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
        return;
      case 2:
        text.erase(at, length);
        return;
      case 3:
        text.insert(below(text.size() + 1), text.substr(at, length));
        return;
      case 4:
        text.resize(at);
        return;
      case 5: {  // a part of another file
        const std::string& other = corpus_[below(corpus_.size())];
        const std::size_t from = below(other.size() + 1);
        text.insert(at, other.substr(from, 1 + below(200)));
        return;
      }
      case 6: {  // four bytes, as in binary files
        const std::size_t value = below(2) == 0 ? below(256) : random_();
        for (std::size_t i = 0; i < 4 && at + i < text.size(); ++i) {
          text[at + i] = static_cast<char>(value >> (8 * i));
        }
        return;
      }
      default:
        change_number(text, at);
    }
  }

  void change_number(std::string& text, std::size_t at) {
    const auto is_part = [](char c) {
      return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-';
    };
    const auto begin =
        std::find_if(text.begin() + static_cast<std::ptrdiff_t>(at), text.end(), is_part);
    const auto end = std::find_if_not(begin, text.end(), is_part);
    text.replace(begin, end, kNumbers[below(kNumbers.size())]);
  }

  const std::vector<std::string>& corpus_;
  std::mt19937 random_;
};

struct Slowest {
  std::chrono::duration<double> time{};
  std::string input;
};

void run(const std::string& text, Slowest& slowest) {
  const auto start = std::chrono::steady_clock::now();
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  const auto time = std::chrono::steady_clock::now() - start;
  if (time > slowest.time) slowest = {time, text};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "%s CORPUS MUTATIONS [SEED [SLOWEST]]\n", argv[0]);
    return 2;
  }
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1]))
    paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  if (paths.empty()) return 2;
  std::vector<std::string> corpus;
  Slowest slowest;
  for (const auto& path : paths) {
    std::stringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    corpus.push_back(text.str());
    run(corpus.back(), slowest);
  }
  const long mutations = std::strtol(argv[2], nullptr, 10);
  Mutator mutator(corpus, argc > 3 ? static_cast<unsigned>(std::strtoul(argv[3], nullptr, 10)) : 1);
  for (long i = 0; i < mutations; ++i) run(mutator.next(), slowest);
  std::printf("%zu files and %ld mutations, at most %.3g s each\n", corpus.size(), mutations,
              slowest.time.count());
  if (argc > 4) std::ofstream(argv[4], std::ios::binary) << slowest.input;
  return 0;
}
