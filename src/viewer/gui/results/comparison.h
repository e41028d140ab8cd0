// Two runs side by side.
#pragma once

#include <QSplitter>
#include <memory>

#include "viewer/gui/body/body_view.h"
#include "viewer/gui/replay/replay.h"

class QLabel;

namespace tetraction::viewer {

/// Shows the picture of the window, and, if there is a second run, its picture beside it, with the name of each run
/// below. Both pictures have one camera, one time and one range of colours.
class Comparison : public QSplitter {
  Q_OBJECT

 public:
  explicit Comparison(BodyView* first);

  /// Shows a second run. Ends the comparison if `second` is null.
  void begin(const QString& first_name, std::unique_ptr<Replay> second,
             std::shared_ptr<const BodyShape> shape);
  const Replay* second() const { return second_.get(); }
  /// The picture of the second run; null without one.
  BodyView* second_view() const { return view_; }
  /// Shows the second run as the picture of the first one shows its run. Throws FileError.
  void follow();
  /// The picture, or both pictures side by side with the names of the runs below. An empty size is that of the window.
  QImage picture(const QSize& size = {});
  /// See BodyView::set_recording().
  void set_recording(bool on);

 private:
  static void copy_camera(BodyView* from, BodyView* to);

  BodyView* first_;
  int first_width_ = 0;  // the least one
  QString first_name_;
  std::unique_ptr<Replay> second_;
  std::shared_ptr<const BodyShape> shape_;  // of its body
  std::size_t frame_ = 0;                   // of the second run, that was read last
  std::shared_ptr<const Snapshot> state_;   // its state
  QWidget* page_ = nullptr;                 // of the second run
  BodyView* view_ = nullptr;
  QLabel *first_label_, *label_ = nullptr;
};

}  // namespace tetraction::viewer
