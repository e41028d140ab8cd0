#include "gmsh_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <utility>

#include "core/quoting.h"
#include "gmsh1_reader.h"
#include "gmsh_builder.h"
#include "gmsh_data.h"
#include "gmsh_entities.h"
#include "gmsh_numbers.h"
#include "io/text/file_kind.h"
#include "io/text/text_scanner.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

class GmshReader {
 public:
  explicit GmshReader(const std::string& path)
      : text_(read_file(path)),
        in_(path, text_),
        numbers_(in_),
        entities_(in_, numbers_),
        mesh_(path) {}

  RawMesh read(std::vector<std::string>& unused) {
    refuse_other_kinds(in_.path(), text_, kGmshKind);
    const std::string_view first = first_section();
    if (first == "$NOD") {
      read_gmsh1(in_, mesh_);
      return mesh_.take(unused);
    }
    if (first != "$MeshFormat") {
      throw FileError(in_.path() +
                      ": is not a Gmsh mesh: it begins with neither $MeshFormat nor $NOD.");
    }
    read_format();
    while (!in_.at_end()) {
      const std::string section(in_.token("a section"));
      if (section.size() < 2 || section[0] != '$') {
        in_.fail(fmt::format("{} where a section such as $Nodes is expected.", in_quotes(section)));
      }
      in_.set_section(section);
      read_section(section);
    }
    const bool nodes = sections_.contains("$Nodes");
    if (!nodes || !sections_.contains("$Elements")) {
      in_.fail(fmt::format("the file has no ${} section: it is truncated or holds no mesh.",
                           nodes ? "Elements" : "Nodes"));
    }
    return mesh_.take(unused);
  }

 private:
  // The types that the format calls int, size_t and double.
  std::int64_t int32(const char* wanted) { return numbers_.int32(wanted); }
  std::int64_t size(const char* wanted) { return numbers_.size(wanted); }
  double real(const char* wanted) { return numbers_.real(wanted); }
  std::int64_t checked(std::int64_t count, const char* wanted, std::int64_t least_bytes) const {
    return in_.checked_count(count, wanted, least_bytes);
  }
  std::int64_t count(const char* wanted, std::int64_t least_bytes) {
    return checked(size(wanted), wanted, least_bytes);
  }

  void read_section(const std::string& section) {
    take_once(section);
    if (section == "$PhysicalNames") {
      read_physical_names();
    } else if (section == "$Entities") {
      entities_.read();
    } else if (section == "$PartitionedEntities") {
      entities_.read_partitioned();
    } else if (section == "$GhostElements") {
      read_ghosts();
    } else if (is_nodes(section)) {
      version4_ ? read_nodes4() : read_nodes2(section == "$ParametricNodes");
    } else if (section == "$Elements") {
      version4_ ? read_elements4() : read_elements2();
    } else if (section == "$ElementData") {
      add_array(read_gmsh_data(in_, numbers_, "element"), &GmshBuilder::add_cell_array);
    } else if (section == "$NodeData") {
      add_array(read_gmsh_data(in_, numbers_, "node"), &GmshBuilder::add_point_array);
    } else {
      if (section != "$Comments") mesh_.skip(section);
      skip_section(section);
      return;
    }
    end_section(section);
  }

  // Version 2 has both kinds, of which a file has one.
  bool is_nodes(const std::string& section) const {
    return section == "$Nodes" || (section == "$ParametricNodes" && !version4_);
  }

  // Refuses what a file may have once if it is there before, or too late for the elements.
  void take_once(const std::string& section) {
    constexpr std::array<std::string_view, 6> kSingle{
        "$MeshFormat", "$PhysicalNames",       "$Entities",
        "$Elements",   "$PartitionedEntities", "$GhostElements"};
    const bool single = std::find(kSingle.begin(), kSingle.end(), section) != kSingle.end();
    if (!single && !is_nodes(section)) return;
    if (!sections_.insert(single ? section : "$Nodes").second) {
      in_.fail(fmt::format("there is a second {} section, and twice is ambiguous.", section));
    }
    if (section.ends_with("Entities") && sections_.contains("$Elements")) {
      in_.fail("it must come before $Elements, whose groups it has.");
    }
  }

  void add_array(GmshData data, bool (GmshBuilder::*add)(GmshData)) {
    const std::string name = data.name;
    if (!(mesh_.*add)(std::move(data))) {
      in_.fail(
          fmt::format("there are several arrays {}, perhaps of several times, and which of them "
                      "holds is ambiguous. Keep one.",
                      in_quotes(name)));
    }
  }

  void read_ghosts() {
    numbers_.begin_section();
    if (const std::int64_t ghosts = count("the number of ghost elements", 2); ghosts > 0) {
      refuse_gmsh_ghosts(in_, fmt::format("the file has {} ghost elements", ghosts));
    }
  }

  // Comments may come before it.
  std::string_view first_section() {
    while (!in_.at_end()) {
      const std::string_view section = in_.token("$MeshFormat");
      if (section != "$Comments") return section;
      skip_section("$Comments");
    }
    return {};
  }

  void read_format() {
    const double version = in_.real("the version");
    const std::int64_t type = in_.integer("the file type");
    const std::int64_t data_size = in_.integer("the data size");
    // 2.0 and 2.1 differ from 2.2 in the physical names only.
    const bool version2 = version == 2.0 || version == 2.1 || version == 2.2;
    version4_ = version == 4.1;
    if (!version2 && !version4_) {
      const bool whole = version == std::floor(version) && std::abs(version) < 1e6;
      in_.fail(
          fmt::format("the mesh is in the MSH format {}, which is not read. Save it in version 4.1 "
                      "or 2.2, for instance with gmsh {} -save -format msh41 -o NEW.msh.",
                      whole ? fmt::format("{:.1f}", version) : fmt::format("{}", version),
                      std::filesystem::path(in_.path()).filename().string()));
    }
    if (type != 0 && type != 1) in_.fail(fmt::format("file type {} is neither 0 nor 1.", type));
    if (data_size != 8) {
      in_.fail(
          fmt::format("data size {} is not 8. Save it anew with Gmsh, which writes 8.", data_size));
    }
    if (type == 1) numbers_.begin_binary_file();
    sections_.insert("$MeshFormat");
    end_section("$MeshFormat");
  }

  void end_section(const std::string& section) {
    const std::string end = fmt::format("$End{}", section.substr(1));
    const std::string_view found = in_.token(end.c_str());
    if (found != end) {
      in_.fail(fmt::format("{} where {} is expected: the numbers in the section do not fit.",
                           in_quotes(found), excerpt(end)));
    }
    in_.set_section("");
  }

  void skip_section(const std::string& section) {
    const std::string end = fmt::format("$End{}", section.substr(1));
    const auto found = text_.find(end, in_.position());
    if (found == std::string::npos) in_.fail("the section does not end: the file is truncated.");
    in_.set_position(found + end.size());
    in_.set_section("");
  }

  void read_physical_names() {
    const std::int64_t names = in_.count("the number of physical names", 5);
    for (std::int64_t i = 0; i < names; ++i) {
      // Version 2.0 does not say the dimension.
      std::int64_t dimension = GmshBuilder::kAnyDimension;
      std::int64_t tag = in_.integer("a dimension or a physical tag");
      if (!in_.next_is('"')) {
        dimension = tag;
        tag = in_.integer("a physical tag");
      }
      const std::string name = quoted_text(in_, in_.line(), "a physical name is not in quotes.");
      if (!mesh_.name_group(dimension, tag, name)) {
        in_.fail(
            fmt::format("physical group {} has two names, the second of which is {}: what is "
                        "named twice is ambiguous.",
                        tag, in_quotes(name)));
      }
    }
  }

  void add_vertex(std::int64_t tag) {
    Vector3 x;
    for (Index i = 0; i < 3; ++i) x[i] = real("a coordinate");
    mesh_.add_vertex(tag, x);
  }

  // Parametric nodes have the dimension and the tag of the entity on which they lie, and their coordinates
  // on a curve or a surface. None of these is needed here.
  void skip_parameters() {
    const std::int64_t dimension = int32("an entity dimension");
    if (dimension < 0 || dimension > 3) in_.fail("an entity dimension is not 0 to 3.");
    int32("an entity tag");
    for (std::int64_t p = 0; dimension < 3 && p < dimension; ++p) real("a parameter");
  }

  void read_nodes2(bool parametric) {
    // The count is text in both variants.
    const std::int64_t nodes =
        checked(in_.integer("the number of nodes"), "the number of nodes", 8);
    mesh_.expect_vertices(nodes);
    numbers_.begin_section();
    for (std::int64_t i = 0; i < nodes; ++i) {
      const std::int64_t tag = int32("a node tag");
      add_vertex(tag);
      if (parametric) skip_parameters();
    }
  }

  void read_nodes4() {
    numbers_.begin_section();
    const std::int64_t blocks = count("the number of node blocks", 8);
    const std::int64_t nodes = count("the number of nodes", 8);
    mesh_.expect_vertices(nodes);
    size("the least node tag");
    size("the largest node tag");
    for (std::int64_t b = 0; b < blocks; ++b) {
      const std::int64_t dimension = int32("an entity dimension");
      int32("an entity tag");
      const std::int64_t parametric = int32("the parametric flag");
      if (dimension < 0 || dimension > 3) in_.fail("an entity dimension is not 0 to 3.");
      const std::int64_t in_block = count("the number of nodes of a block", 8);
      std::vector<std::int64_t> tags;
      for (std::int64_t i = 0; i < in_block; ++i) tags.push_back(size("a node tag"));
      for (const std::int64_t tag : tags) {
        add_vertex(tag);
        // Coordinates on the curve or surface follow, which are not needed here.
        for (std::int64_t p = 0; parametric != 0 && p < dimension; ++p) real("a parameter");
      }
    }
    if (static_cast<std::int64_t>(mesh_.vertex_count()) != nodes) {
      in_.fail(fmt::format("$Nodes announces {} nodes and holds {}.", nodes, mesh_.vertex_count()));
    }
  }

  const GmshType& element_type(std::int64_t number) {
    const GmshType* type = find_gmsh_type(number);
    if (type == nullptr)
      in_.fail(fmt::format("element type {} is not known to this reader.", number));
    return *type;
  }

  std::vector<std::int64_t> read_cell_nodes(const GmshType& type, bool wide) {
    std::vector<std::int64_t> nodes;
    nodes.reserve(static_cast<std::size_t>(type.nodes));
    for (int i = 0; i < type.nodes; ++i) {
      nodes.push_back(wide ? size("a node of an element") : int32("a node of an element"));
    }
    return nodes;
  }

  // The physical tag, the elementary tag, the number of partitions and the partitions.
  void read_cell2(const GmshType& type, std::int64_t tag, std::int64_t tags) {
    std::vector<std::int64_t> physicals;
    std::int64_t partitions = 0;
    for (std::int64_t t = 0; t < tags; ++t) {
      const std::int64_t value = int32(t == 0 ? "a physical tag" : "an element tag");
      // The sign is the orientation, and 0 is no group.
      if (t == 0 && value != 0) physicals.push_back(std::abs(value));
      if (t == 2) partitions = value;
      if (t > 2 && t - 2 <= partitions && value < 0) {
        refuse_gmsh_ghosts(in_, fmt::format("element {} is a ghost in partition {}", tag, -value));
      }
    }
    mesh_.add_cell(type, tag, read_cell_nodes(type, false), physicals);
  }

  void read_elements2() {
    const std::int64_t elements =
        checked(in_.integer("the number of elements"), "the number of elements", 8);
    mesh_.expect_cells(elements);
    numbers_.begin_section();
    if (!numbers_.binary()) {
      for (std::int64_t i = 0; i < elements; ++i) {
        const std::int64_t tag = in_.integer("an element number");
        const GmshType& type = element_type(in_.integer("an element type"));
        read_cell2(type, tag, in_.count("the number of tags", 1));
      }
      return;
    }
    for (std::int64_t i = 0; i < elements;) {
      const GmshType& type = element_type(int32("an element type"));
      const std::int64_t in_block = checked(int32("the number of elements of a block"),
                                            "the number of elements of a block", 8);
      const std::int64_t tags = checked(int32("the number of tags"), "the number of tags", 4);
      if (in_block < 1) in_.fail("a block of elements is empty.");
      if (in_block > elements - i) {
        in_.fail(fmt::format("$Elements announces {} elements and holds more.", elements));
      }
      for (std::int64_t e = 0; e < in_block; ++e)
        read_cell2(type, int32("an element number"), tags);
      i += in_block;
    }
  }

  void read_elements4() {
    numbers_.begin_section();
    const std::int64_t blocks = count("the number of element blocks", 8);
    const std::int64_t elements = count("the number of elements", 4);
    mesh_.expect_cells(elements);
    size("the least element tag");
    size("the largest element tag");
    for (std::int64_t b = 0; b < blocks; ++b) {
      const std::int64_t dimension = int32("an entity dimension");
      const std::int64_t entity = int32("an entity tag");
      const GmshType& type = element_type(int32("an element type"));
      const std::int64_t in_block = count("the number of elements of a block", 4);
      if (dimension != type.dimension) {
        in_.fail(fmt::format(
            "elements of dimension {} stand under an entity of dimension {}, whose groups they "
            "cannot have.",
            type.dimension, dimension));
      }
      if (entities_.lacks(dimension, entity)) {
        in_.fail(fmt::format(
            "entity {} of dimension {} has elements and is not among the entities of the file, so "
            "that their groups are not known.",
            entity, dimension));
      }
      const std::vector<std::int64_t>& physicals = entities_.physicals_of(dimension, entity);
      for (std::int64_t e = 0; e < in_block; ++e) {
        const std::int64_t tag = size("an element tag");
        mesh_.add_cell(type, tag, read_cell_nodes(type, true), physicals);
      }
    }
    if (static_cast<std::int64_t>(mesh_.cell_count()) != elements) {
      in_.fail(fmt::format("$Elements announces {} elements and holds {}.", elements,
                           mesh_.cell_count()));
    }
    // Version 4 gives an element once, whatever its groups.
    if (const auto tag = mesh_.repeated_tetrahedron()) {
      in_.fail(fmt::format(
          "tetrahedron {} is given twice, and which of them is meant is ambiguous.", *tag));
    }
  }

  std::string text_;
  TextScanner in_;
  GmshNumbers numbers_;
  GmshEntities entities_;
  GmshBuilder mesh_;
  bool version4_ = false;
  std::set<std::string> sections_;  // of those that a file may have once, those that it has
};

}  // namespace

RawMesh read_gmsh(const std::string& path, std::vector<std::string>& unused) {
  return GmshReader(path).read(unused);
}

}  // namespace tetraction
