#include "stored_pictures.h"

#include <gtest/gtest.h>
#include <vtkImageData.h>
#include <vtkImageDifference.h>
#include <vtkNew.h>

#include <QDir>
#include <cstdlib>
#include <limits>

namespace tetraction::viewer {
namespace {

void fill(vtkImageData* data, const QImage& picture) {
  const QImage rgb = picture.convertToFormat(QImage::Format_RGB888);
  data->SetDimensions(rgb.width(), rgb.height(), 1);
  data->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  for (int y = 0; y < rgb.height(); ++y) {
    // VTK counts rows from below.
    std::copy_n(rgb.constScanLine(y), 3 * rgb.width(),
                static_cast<unsigned char*>(data->GetScalarPointer(0, rgb.height() - 1 - y, 0)));
  }
}

QString stored_path(const std::string& name) {
  return QStringLiteral(TETRACTION_STORED_PICTURES "/%1.png").arg(QString::fromStdString(name));
}

}  // namespace

double difference_to_stored(const QImage& picture, const std::string& name) {
  const QImage stored(stored_path(name));
  if (stored.isNull() || stored.size() != picture.size()) {
    return std::numeric_limits<double>::infinity();
  }
  vtkNew<vtkImageData> now;
  vtkNew<vtkImageData> before;
  fill(now, picture);
  fill(before, stored);
  vtkNew<vtkImageDifference> difference;
  difference->SetInputData(now);
  difference->SetImageData(before);
  // These would forgive missing lines.
  difference->AllowShiftOff();
  difference->AveragingOff();
  difference->Update();
  return difference->GetThresholdedError();
}

void expect_as_stored(const QImage& picture, const std::string& name, double threshold) {
  QDir().mkpath(QStringLiteral(TETRACTION_SCREENSHOTS));
  const QString kept =
      QStringLiteral(TETRACTION_SCREENSHOTS "/stored_%1.png").arg(QString::fromStdString(name));
  EXPECT_TRUE(picture.save(kept));
  if (std::getenv("TETRACTION_STORE_PICTURES") != nullptr) {
    EXPECT_TRUE(picture.save(stored_path(name)));
    return;
  }
  EXPECT_LT(difference_to_stored(picture, name), threshold)
      << "compare " << kept.toStdString() << " with " << stored_path(name).toStdString();
}

}  // namespace tetraction::viewer
