// Pictures against stored ones.
#pragma once

#include <QImage>
#include <string>

namespace tetraction::viewer {

/// How far a picture is from the stored one of that name (stored_pictures/NAME.png), as
/// vtkImageDifference counts it: differing pixels, weighted by their difference of colour, of which
/// small ones do not count. Infinite where sizes differ or nothing is stored.
double difference_to_stored(const QImage& picture, const std::string& name);

/// Expects a difference below `threshold`. The picture is kept beside the other screenshots; with
/// TETRACTION_STORE_PICTURES set it is stored instead: look at it before you commit it.
void expect_as_stored(const QImage& picture, const std::string& name, double threshold);

}  // namespace tetraction::viewer
