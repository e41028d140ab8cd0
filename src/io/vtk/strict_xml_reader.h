// VTK's reader of VTU files, which also checks what VTK leaves unchecked.
#pragma once

#include <vtkXMLUnstructuredGridReader.h>

#include <string>
#include <vector>

namespace tetraction {

/// Reads as its base class. trouble() says what makes the file ambiguous: sections or arrays that are
/// given twice, pieces with different arrays, binary arrays that have more or fewer numbers than they
/// should, and types of cells that eight
/// bits do not hold. check_xml_header() has looked at arrays in text.
class StrictXmlReader : public vtkXMLUnstructuredGridReader {
 public:
  static StrictXmlReader* New();
  vtkTypeMacro(StrictXmlReader, vtkXMLUnstructuredGridReader);

  /// The defect of the file, after Update(); empty if there is none.
  const std::string& trouble() const { return trouble_; }

 protected:
  StrictXmlReader() = default;

  int ReadPiece(vtkXMLDataElement* piece) override;
  int ReadPieceData() override;

 private:
  void find_trouble(const std::string& what) {
    if (trouble_.empty()) trouble_ = what;
  }
  void check_names(vtkXMLDataElement* section);
  void check_length(vtkXMLDataElement* array, vtkIdType values);
  void check_types(vtkXMLDataElement* array);

  std::string trouble_;
  std::vector<std::string> names_of_first_piece_;
  vtkIdType connectivity_ = 0;  // numbers of this array in the pieces so far
};

}  // namespace tetraction
