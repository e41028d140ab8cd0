#include "gmsh_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <utility>

#include "core/quoting.h"
#include "gmsh1_reader.h"
#include "gmsh_builder.h"
#include "gmsh_numbers.h"
#include "io/text/text_scanner.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// No real mesh has more groups for one entity. Each element of an entity joins all of its groups,
// so without this limit a small file could require any amount of memory.
constexpr std::int64_t kMostPhysicals = 100;

class GmshReader {
 public:
  explicit GmshReader(const std::string& path)
      : text_(read_file(path)), in_(path, text_), numbers_(in_), mesh_(path) {}

  RawMesh read() {
    const std::string_view first = first_section();
    if (first == "$NOD") {
      read_gmsh1(in_, mesh_);
      return mesh_.take();
    }
    if (first != "$MeshFormat") {
      throw FileError(in_.path() +
                      ": is not a Gmsh mesh: it begins with neither $MeshFormat nor $NOD.");
    }
    read_format();
    bool nodes = false;
    bool elements = false;
    while (!in_.at_end()) {
      const std::string section(in_.token("a section"));
      if (section.size() < 2 || section[0] != '$') {
        in_.fail(fmt::format("{} where a section such as $Nodes is expected.", in_quotes(section)));
      }
      in_.set_section(section);
      if (section == "$PhysicalNames") {
        read_physical_names();
      } else if (section == "$Entities") {
        numbers_.begin_section();
        read_entities();
      } else if (section == "$Nodes") {
        if (std::exchange(nodes, true)) in_.fail("there is a second $Nodes section.");
        version4_ ? read_nodes4() : read_nodes2();
      } else if (section == "$Elements") {
        if (std::exchange(elements, true)) in_.fail("there is a second $Elements section.");
        version4_ ? read_elements4() : read_elements2();
      } else if (section == "$ElementData") {
        read_element_data();
      } else {
        skip_section(section);
        in_.set_section("");
        continue;
      }
      end_section(section);
    }
    if (!nodes || !elements) {
      in_.fail(fmt::format("the file has no ${} section: it is truncated or holds no mesh.",
                           nodes ? "Elements" : "Nodes"));
    }
    return mesh_.take();
  }

 private:
  // What the format calls int, size_t and double.
  std::int64_t int32(const char* wanted) { return numbers_.int32(wanted); }
  std::int64_t size(const char* wanted) { return numbers_.size(wanted); }
  double real(const char* wanted) { return numbers_.real(wanted); }
  std::int64_t checked(std::int64_t count, const char* wanted, std::int64_t least_bytes) const {
    return in_.checked_count(count, wanted, least_bytes);
  }
  std::int64_t count(const char* wanted, std::int64_t least_bytes) {
    return checked(size(wanted), wanted, least_bytes);
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
      const std::string line(in_.line());
      const auto open = line.find('"');
      const auto close = line.rfind('"');
      if (open == std::string::npos || close == open) in_.fail("a physical name is not in quotes.");
      mesh_.name_group(dimension, tag, line.substr(open + 1, close - open - 1));
    }
  }

  void read_entities() {
    std::array<std::int64_t, 4> counts{};
    for (auto& n : counts) n = count("a number of entities", 4);
    for (int dimension = 0; dimension < 4; ++dimension) {
      for (std::int64_t i = 0; i < counts[static_cast<std::size_t>(dimension)]; ++i) {
        const std::int64_t tag = int32("an entity tag");
        const int coordinates = dimension == 0 ? 3 : 6;
        for (int c = 0; c < coordinates; ++c) real("an entity's bounds");
        const std::int64_t physicals = count("a number of physical tags", 2);
        const auto [entity, is_new] =
            physicals_.emplace(std::pair{dimension, tag}, std::vector<std::int64_t>{});
        if (!is_new) {
          in_.fail(
              fmt::format("entity {} of dimension {} is given a second time.", tag, dimension));
        }
        if (physicals > kMostPhysicals) {
          in_.fail(fmt::format("an entity has {} physical tags; at most {} are read.", physicals,
                               kMostPhysicals));
        }
        for (std::int64_t p = 0; p < physicals; ++p) {
          const std::int64_t physical = physical_tag();
          std::vector<std::int64_t>& known = entity->second;
          if (std::find(known.begin(), known.end(), physical) == known.end()) {
            known.push_back(physical);
          }
        }
        if (dimension == 0) continue;
        const std::int64_t bounding = count("a number of bounding entities", 2);
        for (std::int64_t b = 0; b < bounding; ++b) int32("a bounding entity");
      }
    }
  }

  void add_vertex(std::int64_t tag) {
    Vector3 x;
    for (Index i = 0; i < 3; ++i) x[i] = real("a coordinate");
    mesh_.add_vertex(tag, x);
  }

  void read_nodes2() {
    // The count is text in both variants.
    const std::int64_t nodes =
        checked(in_.integer("the number of nodes"), "the number of nodes", 8);
    mesh_.expect_vertices(nodes);
    numbers_.begin_section();
    for (std::int64_t i = 0; i < nodes; ++i) {
      const std::int64_t tag = int32("a node tag");
      add_vertex(tag);
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

  // A tag is negative if a group contains an entity with reversed orientation.
  std::int64_t physical_tag() { return std::abs(int32("a physical tag")); }

  std::vector<std::int64_t> read_cell_nodes(const GmshType& type, bool wide) {
    std::vector<std::int64_t> nodes;
    nodes.reserve(static_cast<std::size_t>(type.nodes));
    for (int i = 0; i < type.nodes; ++i) {
      nodes.push_back(wide ? size("a node of an element") : int32("a node of an element"));
    }
    return nodes;
  }

  void read_cell2(const GmshType& type, std::int64_t tag, std::int64_t tags) {
    std::vector<std::int64_t> physicals;
    for (std::int64_t t = 0; t < tags; ++t) {
      if (t > 0) {
        int32("an element tag");
      } else if (const std::int64_t physical = physical_tag(); physical != 0) {
        physicals.push_back(physical);
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
      const auto found = physicals_.find({static_cast<int>(dimension), entity});
      const std::vector<std::int64_t> physicals =
          found != physicals_.end() ? found->second : std::vector<std::int64_t>{};
      for (std::int64_t e = 0; e < in_block; ++e) {
        const std::int64_t tag = size("an element tag");
        mesh_.add_cell(type, tag, read_cell_nodes(type, true), physicals);
      }
    }
    if (static_cast<std::int64_t>(mesh_.cell_count()) != elements) {
      in_.fail(fmt::format("$Elements announces {} elements and holds {}.", elements,
                           mesh_.cell_count()));
    }
  }

  // Texts of which the first is the array's name; real numbers; whole numbers, of which the second is
  // the number of components and the third the number of elements; then a row for each element. All
  // but the rows is text in both variants.
  void read_element_data() {
    const std::int64_t texts = in_.count("the number of texts", 2);
    std::string name;
    for (std::int64_t i = 0; i < texts; ++i) {
      if (!in_.next_is('"')) in_.fail("a text is not in quotes.");
      const std::string line(in_.line());
      const auto open = line.find('"');
      const auto close = line.rfind('"');
      if (close == open) in_.fail("a text does not end.");
      if (i == 0) name = line.substr(open + 1, close - open - 1);
    }
    const std::int64_t reals = in_.count("the number of real numbers", 2);
    for (std::int64_t i = 0; i < reals; ++i) in_.real("a real number");
    const std::int64_t integers = in_.count("the number of whole numbers", 2);
    if (integers < 3) in_.fail("the numbers of components and elements are missing.");
    std::array<std::int64_t, 3> numbers{};
    for (std::int64_t i = 0; i < integers; ++i) {
      const std::int64_t value = in_.integer("a whole number");
      if (i < 3) numbers[static_cast<std::size_t>(i)] = value;
    }
    const std::int64_t components = numbers[1];
    if (components != 1 && components != 3 && components != 9) {
      in_.fail(fmt::format("an array has {} components, but 1, 3 and 9 are possible.", components));
    }
    numbers_.begin_section();
    const std::int64_t rows = checked(numbers[2], "the number of elements with data",
                                      numbers_.binary() ? 4 + 8 * components : 2 * components + 2);
    std::vector<std::int64_t> tags;
    Matrix values(components, rows);
    for (std::int64_t r = 0; r < rows; ++r) {
      tags.push_back(int32("an element number"));
      for (std::int64_t k = 0; k < components; ++k) values(k, r) = real("a number of an element");
    }
    mesh_.add_cell_array(name, tags, std::move(values));
  }

  std::string text_;
  TextScanner in_;
  GmshNumbers numbers_;
  GmshBuilder mesh_;
  bool version4_ = false;
  std::map<std::pair<int, std::int64_t>, std::vector<std::int64_t>> physicals_;
};

}  // namespace

RawMesh read_gmsh(const std::string& path) {
  return GmshReader(path).read();
}

}  // namespace tetraction
