#include "strict_xml_reader.h"

#include <fmt/format.h>
#include <vtkAbstractArray.h>
#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkObjectFactory.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>

#include <algorithm>
#include <array>
#include <set>
#include <string_view>

#include "core/quoting.h"

namespace tetraction {
namespace {

std::string name_of(vtkXMLDataElement* array) {
  const char* name = array->GetAttribute("Name");
  return name != nullptr ? name : "";
}

bool is_called(vtkXMLDataElement* element, std::string_view name) {
  return element->GetName() == name;
}

template <class Use>
void for_each_array(vtkXMLDataElement* section, const Use& use) {
  for (int i = 0; section != nullptr && i < section->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* array = section->GetNestedElement(i);
    if (is_called(array, "DataArray") || is_called(array, "Array")) use(array);
  }
}

}  // namespace

vtkStandardNewMacro(StrictXmlReader);

void StrictXmlReader::check_names(vtkXMLDataElement* section) {
  std::set<std::string> names;
  for_each_array(section, [&](vtkXMLDataElement* array) {
    if (names.insert(name_of(array)).second) return;
    find_trouble(
        fmt::format("the array {} of its <{}> is given twice, and which of both holds is "
                    "ambiguous",
                    in_quotes(name_of(array)), section->GetName()));
  });
}

// VTK takes the last of several sections, and of several arrays with the same name. Arrays of later pieces
// it takes in the order of those of the first one, whatever their names are.
int StrictXmlReader::ReadPiece(vtkXMLDataElement* piece) {
  std::set<std::string> sections;
  std::vector<std::string> names;
  for (int i = 0; i < piece->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* section = piece->GetNestedElement(i);
    if (!sections.insert(section->GetName()).second) {
      find_trouble(
          fmt::format("the section <{}> is given twice, and which of both holds is ambiguous",
                      section->GetName()));
    }
    check_names(section);
    if (!is_called(section, "PointData") && !is_called(section, "CellData")) continue;
    for_each_array(section, [&](vtkXMLDataElement* array) {
      names.push_back(fmt::format("{} {}", section->GetName(), name_of(array)));
    });
  }
  std::stable_sort(names.begin(), names.end(), [](const std::string& a, const std::string& b) {
    return a.substr(0, a.find(' ')) < b.substr(0, b.find(' '));
  });
  if (Piece == 0) names_of_first_piece_ = names;
  if (names != names_of_first_piece_) {
    find_trouble(
        "its pieces have different arrays, or the same in another order, which is ambiguous");
  }
  // VTK crashes on some of these files.
  return trouble_.empty() ? Superclass::ReadPiece(piece) : 0;
}

// Asks VTK for the last value and one more.
void StrictXmlReader::check_length(vtkXMLDataElement* array, vtkIdType values) {
  const char* format = array->GetAttribute("format");
  vtkTypeInt64 offset = 0;
  const bool appended = array->GetScalarAttribute("offset", offset) != 0;
  const bool in_text = !appended && (format == nullptr || std::string_view(format) != "binary");
  int type = 0;
  if (in_text || values < 1 || array->GetWordTypeAttribute("type", type) == 0 ||
      type == VTK_STRING || type == VTK_BIT) {
    return;
  }
  std::array<double, 2> last{};
  const auto first = static_cast<vtkTypeUInt64>(values - 1);
  const std::size_t count = appended
                                ? XMLParser->ReadAppendedData(offset, last.data(), first, 2, type)
                                : XMLParser->ReadInlineData(array, 0, last.data(), first, 2, type);
  if (count == 1) return;
  find_trouble(count > 1
                   ? fmt::format("its array {} has more than the {} numbers that it should have, "
                                 "which is ambiguous",
                                 in_quotes(name_of(array)), values)
                   : fmt::format("its array {} has fewer than the {} numbers that it should have",
                                 in_quotes(name_of(array)), values));
}

// VTK keeps the lowest eight bits.
void StrictXmlReader::check_types(vtkXMLDataElement* array) {
  int type = 0;
  const bool wide = array->GetWordTypeAttribute("type", type) != 0 && type != VTK_UNSIGNED_CHAR;
  if (!wide) return;
  const auto created = vtkSmartPointer<vtkAbstractArray>::Take(CreateArray(array));
  auto* values = vtkDataArray::SafeDownCast(created);
  const vtkIdType cells = NumberOfCells[Piece];
  if (values == nullptr || values->GetNumberOfComponents() != 1) return;
  values->SetNumberOfTuples(cells);
  if (ReadArrayValues(array, 0, values, 0, cells) == 0) return;
  for (vtkIdType c = 0; c < cells; ++c) {
    const double value = values->GetTuple1(c);
    if (value >= 0.0 && value <= 255.0) continue;
    find_trouble(fmt::format("the type {} of cell {} is not a number from 0 to 255", value, c));
    return;
  }
}

int StrictXmlReader::ReadPieceData() {
  if (Superclass::ReadPieceData() == 0) return 0;
  const vtkIdType points = NumberOfPoints[Piece];
  const vtkIdType cells = NumberOfCells[Piece];
  auto* grid = vtkUnstructuredGrid::SafeDownCast(GetCurrentOutput());
  const vtkIdType connectivity = grid->GetCells()->GetNumberOfConnectivityIds() - connectivity_;
  connectivity_ += connectivity;
  const auto check_all = [this](vtkXMLDataElement* section, vtkIdType items, int usual) {
    for_each_array(section, [&](vtkXMLDataElement* array) {
      int components = usual;
      array->GetScalarAttribute("NumberOfComponents", components);
      check_length(array, std::max(components, 1) * items);
    });
  };
  check_all(PointDataElements[Piece], points, 1);
  check_all(CellDataElements[Piece], cells, 1);
  check_all(PointElements[Piece], points, 3);
  for_each_array(CellElements[Piece], [&](vtkXMLDataElement* array) {
    const std::string name = name_of(array);
    if (name == "connectivity") check_length(array, connectivity);
    if (name == "offsets" || name == "types") check_length(array, cells);
    if (name == "types" && cells > 0) check_types(array);
  });
  return 1;
}

}  // namespace tetraction
