// Which kind of file a file is by its first bytes, for messages about files with a wrong ending.
#pragma once

#include <string>
#include <string_view>

namespace tetraction {

inline constexpr std::string_view kGmshKind = "a Gmsh mesh (.msh)";
inline constexpr std::string_view kLegacyVtkKind = "a legacy VTK file (.vtk)";
inline constexpr std::string_view kXmlVtkKind = "a VTK file in XML (.vtu)";
inline constexpr std::string_view kVegaKind = "a Vega mesh (.veg)";
inline constexpr std::string_view kTetgenKind = "a TetGen mesh (.node and .ele)";

/// The kind of a text with these first bytes, as the rest of a sentence that begins "it is", such as
/// "a Git LFS pointer, …". Empty if the bytes do not say.
std::string_view kind_of_file(std::string_view text);

/// Throws FileError if the text is that of another kind of file than `wanted`. The message names both.
void refuse_other_kinds(const std::string& path, std::string_view text, std::string_view wanted);

}  // namespace tetraction
