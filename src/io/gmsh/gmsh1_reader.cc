#include "gmsh1_reader.h"

#include <fmt/format.h>

#include <cstdlib>
#include <limits>

#include "core/quoting.h"

namespace tetraction {
namespace {

void expect(TextScanner& in, const char* section) {
  const std::string_view found = in.token(section);
  if (found != section) {
    in.fail(fmt::format("{} where {} is expected: the numbers in the section do not fit.",
                        in_quotes(found), section));
  }
}

void read_nodes(TextScanner& in, GmshBuilder& mesh) {
  const std::int64_t nodes = in.count("the number of nodes", 8);
  for (std::int64_t i = 0; i < nodes; ++i) {
    const std::int64_t tag = in.integer("a node number");
    Vector3 x;
    for (Index c = 0; c < 3; ++c) x[c] = in.real("a coordinate");
    mesh.add_vertex(tag, x);
  }
}

void read_elements(TextScanner& in, GmshBuilder& mesh) {
  const std::int64_t elements = in.count("the number of elements", 12);
  for (std::int64_t i = 0; i < elements; ++i) {
    const std::int64_t tag = in.integer("an element number");
    const std::int64_t number = in.integer("an element type");
    const GmshType* type = find_gmsh_type(number);
    if (type == nullptr)
      in.fail(fmt::format("element type {} is not known to this reader.", number));
    // As in later versions, the sign is the orientation, and 0 is no group.
    const std::int64_t physical = in.integer("a physical tag");
    constexpr std::int64_t kLargest = std::numeric_limits<std::int32_t>::max();
    if (physical < -kLargest || physical > kLargest) {
      in.fail(fmt::format("{} is not a physical tag (an integer of 32 bits).", physical));
    }
    in.integer("an elementary tag");
    if (const std::int64_t nodes = in.integer("a number of nodes"); nodes != type->nodes) {
      in.fail(fmt::format("element {} of type {} has {} nodes instead of {}.", tag, number, nodes,
                          type->nodes));
    }
    std::vector<std::int64_t> nodes;
    nodes.reserve(static_cast<std::size_t>(type->nodes));
    for (int n = 0; n < type->nodes; ++n) nodes.push_back(in.integer("a node of an element"));
    std::vector<std::int64_t> physicals;
    if (physical != 0) physicals.push_back(std::abs(physical));
    mesh.add_cell(*type, tag, std::move(nodes), physicals);
  }
}

}  // namespace

void read_gmsh1(TextScanner& in, GmshBuilder& mesh) {
  in.set_section("$NOD");
  read_nodes(in, mesh);
  expect(in, "$ENDNOD");
  in.set_section("");
  expect(in, "$ELM");
  in.set_section("$ELM");
  read_elements(in, mesh);
  expect(in, "$ENDELM");
  in.set_section("");
  if (in.at_end()) return;
  const std::string_view rest = in.text().substr(in.position());
  for (const char* section : {"$NOD", "$ELM"}) {
    if (rest.find(section) == rest.npos) continue;
    in.fail(fmt::format("there is a second {} section, and twice is ambiguous.", section));
  }
  mesh.skip(std::string(in.token("a section")));
}

}  // namespace tetraction
