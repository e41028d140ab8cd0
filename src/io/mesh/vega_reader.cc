#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/quoting.h"
#include "io/text/file_kind.h"
#include "io/text/text_scanner.h"
#include "mesh_text.h"
#include "plain_readers.h"

namespace tetraction {
namespace {

// Comments are lines that begin with #. They are replaced by blanks, so that line numbers stay
// right.
std::string without_comment_lines(std::string text) {
  bool comment = false;
  bool line_begins = true;
  for (char& c : text) {
    if (line_begins && c == '#') comment = true;
    if (c == '\n') {
      comment = false;
      line_begins = true;
      continue;
    }
    if (c != ' ' && c != '\t') line_begins = false;
    if (comment) c = ' ';
  }
  return text;
}

std::string read_vega_text(const std::string& path) {
  std::string text = read_file(path);
  refuse_other_kinds(path, text, kVegaKind);
  return without_comment_lines(std::move(text));
}

class VegaReader {
 public:
  explicit VegaReader(const std::string& path) : text_(read_vega_text(path)), in_(path, text_) {
    mesh_.source = path;
  }

  RawMesh read(std::vector<std::string>& unused) {
    while (!in_.at_end()) {
      const std::string section(in_.token("a section"));
      if (section == "*VERTICES") {
        read_vertices();
      } else if (section == "*ELEMENTS") {
        read_elements();
      } else if (section == "*SET") {
        read_set();
      } else if (section == "*REGION") {
        read_region();
      } else if (section == "*MATERIAL") {
        read_material();
      } else if (section == "*INCLUDE") {
        in_.fail("*INCLUDE is not read: put the included text into the file.");
      } else {
        in_.fail(
            fmt::format("{} where a section such as *VERTICES is expected.", in_quotes(section)));
      }
    }
    if (!has_vertices_ || !has_elements_) {
      in_.fail(fmt::format("the file has no *{} section: it is truncated or holds no mesh.",
                           has_vertices_ ? "ELEMENTS" : "VERTICES"));
    }
    apply_sets();
    unused.insert(unused.end(), unused_.begin(), unused_.end());
    return std::move(mesh_);
  }

 private:
  void read_vertices() {
    if (has_vertices_) in_.fail("there is a second *VERTICES section, and twice is ambiguous.");
    const std::int64_t vertices = in_.count("the number of vertices", 8);
    if (in_.integer("the dimension") != 3) in_.fail("the dimension is not 3.");
    const std::int64_t attributes = in_.count("the number of attributes", 2);
    const std::int64_t markers = in_.integer("the boundary-marker flag");
    if (attributes > 0) unused_.emplace_back("the attributes of the vertices");
    mesh_.vertex_ids.reserve(mesh_.vertex_ids.size() + static_cast<std::size_t>(vertices));
    mesh_.vertices.reserve(mesh_.vertices.size() + static_cast<std::size_t>(vertices));
    for (std::int64_t i = 0; i < vertices; ++i) {
      mesh_.vertex_ids.push_back(in_.integer("a vertex number"));
      Vector3 x;
      for (Index c = 0; c < 3; ++c) x[c] = in_.real("a coordinate");
      mesh_.vertices.push_back(x);
      for (std::int64_t a = 0; a < attributes; ++a) in_.real("a vertex attribute");
      if (markers != 0) in_.integer("a boundary marker");
    }
    has_vertices_ = true;
  }

  void read_elements() {
    const std::string kind(in_.token("the kind of elements"));
    CellType type = CellType::kTetrahedron;
    if (kind == "CUBIC") {
      type = CellType::kHexahedron;
    } else if (kind != "TET" && kind != "TETS") {
      in_.fail(fmt::format("elements of kind {} are not known; there are TET and CUBIC.",
                           in_quotes(kind)));
    }
    const std::int64_t elements = in_.count("the number of elements", 8);
    const std::int64_t nodes = in_.integer("the number of nodes of an element");
    if (nodes != (type == CellType::kTetrahedron ? 4 : 8)) {
      in_.fail(fmt::format("{} elements with {} nodes.", kind, nodes));
    }
    const std::int64_t attributes = in_.count("the number of attributes", 2);
    if (attributes > 0) unused_.emplace_back("the attributes of the elements");
    mesh_.cells.reserve(mesh_.cells.size() + static_cast<std::size_t>(elements));
    for (std::int64_t e = 0; e < elements; ++e) {
      RawCell cell;
      cell.vertices.reserve(static_cast<std::size_t>(nodes));
      cell.type = type;
      cell.id = in_.integer("an element number");
      if (!element_ids_.insert(cell.id).second) {
        in_.fail(fmt::format("element {} is defined twice.", cell.id));
      }
      for (std::int64_t n = 0; n < nodes; ++n) cell.vertices.push_back(in_.integer("a node"));
      for (std::int64_t a = 0; a < attributes; ++a) in_.real("an element attribute");
      mesh_.cells.push_back(std::move(cell));
    }
    has_elements_ = true;
  }

  // Numbers of elements, separated by commas or spaces, up to the next section.
  void read_set() {
    std::string name(in_.line());
    name.erase(0, name.find_first_not_of(" \t"));
    name.erase(name.find_last_not_of(" \t") + 1);
    std::vector<std::int64_t> set;
    const std::string body = body_text();
    const char* place = body.data();
    const char* const end = body.data() + body.size();
    while (place != end) {
      if (*place == ',' || *place == ' ' || *place == '\n' || *place == '\t' || *place == '\r') {
        ++place;
        continue;
      }
      std::int64_t id = 0;
      const auto [next, error] = std::from_chars(place, end, id);
      if (error != std::errc())
        in_.fail(fmt::format("set {} holds what is no number.", in_quotes(name)));
      set.push_back(id);
      place = next;
    }
    const auto [known, is_new] = sets_.emplace(name, set);
    if (is_new) {
      set_order_.push_back(name);
    } else if (known->second != set) {
      in_.fail(fmt::format(
          "there is a second set {} with other elements, and twice is ambiguous: give each "
          "set a name of its own, or put all of its elements into one.",
          in_quotes(name)));
    }
  }

  void read_region() {
    const std::string line(body_text());
    const auto comma = line.find(',');
    std::string set = line.substr(0, comma);
    set.erase(0, set.find_first_not_of(" \t\r\n"));
    set.erase(set.find_last_not_of(" \t\r\n") + 1);
    if (set.empty() || comma == std::string::npos) {
      in_.fail("*REGION needs a set and a material, separated by a comma.");
    }
    regions_.push_back(set);
  }

  std::string body_text() {
    const auto next = std::min(text_.find('*', in_.position()), text_.size());
    std::string body = text_.substr(in_.position(), next - in_.position());
    in_.set_position(next);
    return body;
  }
  void read_material() {
    // Without materials, regions could not be written. So a mesh that this program writes has one.
    std::string name(in_.line());
    if (name.find(kPlaceholderMaterial) == std::string::npos && !std::exchange(materials_, true)) {
      unused_.emplace_back("the materials (a scene has its own)");
    }
    body_text();
  }

  void apply_sets() {
    std::map<std::int64_t, std::size_t> index_of;
    for (std::size_t i = 0; !set_order_.empty() && i < mesh_.cells.size(); ++i) {
      index_of[mesh_.cells[i].id] = i;
    }
    for (const std::string& name : set_order_) {
      const int group = static_cast<int>(mesh_.groups.size());
      mesh_.groups.push_back({name, 3, group + 1});
      for (const std::int64_t id : sets_[name]) {
        const auto found = index_of.find(id);
        if (found == index_of.end()) {
          in_.fail(
              fmt::format("set {} names element {}, which does not exist.", in_quotes(name), id));
        }
        mesh_.cells[found->second].groups.push_back(group);
      }
    }
    // Regions count from 1 in the order of the file; a mesh of one region keeps 0.
    if (regions_.size() < 2) return;
    // If a set has several regions, only the last one has an effect.
    std::map<std::string, std::size_t> last;
    for (std::size_t r = 0; r < regions_.size(); ++r) last[regions_[r]] = r;
    for (std::size_t r = 0; r < regions_.size(); ++r) {
      if (last[regions_[r]] != r) continue;
      const int region = static_cast<int>(r) + 1;
      if (regions_[r] == "allElements") {
        const auto named = sets_.find("allElements");
        if (named != sets_.end() && named->second.size() != mesh_.cells.size()) {
          in_.fail(
              "*REGION names allElements, and there is a set of that name with other elements, "
              "which is ambiguous: give the set another name.");
        }
        for (RawCell& cell : mesh_.cells) cell.region = region;
        continue;
      }
      const auto set = sets_.find(regions_[r]);
      if (set == sets_.end()) {
        in_.fail(
            fmt::format("*REGION names set {}, which does not exist.", in_quotes(regions_[r])));
      }
      for (const std::int64_t id : set->second) mesh_.cells[index_of.at(id)].region = region;
    }
  }

  std::string text_;
  TextScanner in_;
  RawMesh mesh_;
  bool has_vertices_ = false;
  bool has_elements_ = false;
  bool materials_ = false;
  std::unordered_set<std::int64_t> element_ids_;
  std::vector<std::string> unused_;
  std::map<std::string, std::vector<std::int64_t>> sets_;
  std::vector<std::string> set_order_;
  std::vector<std::string> regions_;
};

}  // namespace

RawMesh read_vega(const std::string& path, std::vector<std::string>& unused) {
  return VegaReader(path).read(unused);
}

}  // namespace tetraction
