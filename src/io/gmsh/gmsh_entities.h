// The entities of version 4 of the Gmsh format: which physical groups their elements belong to.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "gmsh_numbers.h"
#include "io/text/text_scanner.h"

namespace tetraction {

class GmshEntities {
 public:
  /// Keeps references to both.
  GmshEntities(TextScanner& in, GmshNumbers& numbers) : in_(in), numbers_(numbers) {}

  /// Reads the body of $Entities. Throws FileError.
  void read();
  /// Reads the body of $PartitionedEntities. Throws FileError, also if there are ghost elements.
  void read_partitioned();

  /// Whether the file lists entities but not this one.
  bool lacks(std::int64_t dimension, std::int64_t tag) const;
  /// The tags of the groups of an entity; none if it is not known.
  const std::vector<std::int64_t>& physicals_of(std::int64_t dimension, std::int64_t tag) const;

 private:
  void read_lists(bool partitioned);
  void read_entity(int dimension, bool partitioned);
  std::int64_t count(const char* wanted, std::int64_t least_bytes);

  TextScanner& in_;
  GmshNumbers& numbers_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::int64_t>> physicals_;
};

/// Refuses a file because of its ghost elements. `what` says which.
[[noreturn]] void refuse_gmsh_ghosts(const TextScanner& in, const std::string& what);

}  // namespace tetraction
