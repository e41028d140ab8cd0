#include "comparison.h"

#include <QDir>
#include <QLabel>
#include <QVBoxLayout>
#include <cmath>
#include <utility>

namespace tetraction::viewer {
namespace {

constexpr int kNarrowest = 180;  // of a picture beside another one, pixels

QLabel* add_page(QSplitter* splitter, BodyView* view) {
  auto* page = new QWidget(splitter);
  auto* column = new QVBoxLayout(page);
  column->setContentsMargins(0, 0, 0, 0);
  column->setSpacing(0);
  column->addWidget(view, 1);
  auto* label = new QLabel(page);
  label->setAlignment(Qt::AlignCenter);
  label->setMargin(4);
  label->setTextFormat(Qt::PlainText);
  label->setMinimumWidth(1);  // a long name does not widen the window
  column->addWidget(label);
  return label;
}

}  // namespace

Comparison::Comparison(BodyView* first)
    : QSplitter(first->parentWidget()), first_(first), first_label_(add_page(this, first)) {
  setChildrenCollapsible(false);
  first_label_->setObjectName(QStringLiteral("first_run"));
  first_label_->hide();
  first_width_ = first->minimumWidth();
}

void Comparison::begin(const QString& first_name, std::unique_ptr<Replay> second,
                       std::shared_ptr<const BodyShape> shape) {
  if (!second && !second_) return;
  delete std::exchange(page_, nullptr);
  view_ = nullptr;
  second_ = std::move(second);
  state_.reset();
  first_name_ = first_name;
  first_label_->setVisible(second_ != nullptr);
  first_->setMinimumWidth(second_ ? kNarrowest : first_width_);
  first_->set_color_bar(!second_);  // the second picture has the bar of both
  if (!second_) return;
  view_ = new BodyView(window());
  view_->setMinimumWidth(kNarrowest);
  label_ = add_page(this, view_);
  label_->setObjectName(QStringLiteral("second_run"));
  page_ = view_->parentWidget();
  setSizes({1000, 1000});
  view_->set_body(std::move(shape));
  copy_camera(first_, view_);
  // Later, because a picture cannot be drawn while another one is.
  connect(
      first_, &BodyView::camera_moved, page_, [this] { copy_camera(first_, view_); },
      Qt::QueuedConnection);
  connect(
      view_, &BodyView::camera_moved, page_, [this] { copy_camera(view_, first_); },
      Qt::QueuedConnection);
  connect(view_, &BodyView::light_turned, first_, &BodyView::light_turned);
}

void Comparison::copy_camera(BodyView* from, BodyView* to) {
  const BodyView::Camera camera = from->camera();
  if (to->camera() != camera) to->set_camera(camera);
}

void Comparison::follow() {
  if (!second_ || !first_->state()) return;
  const double time = first_->state()->time;
  DrawingSettings drawing = first_->drawing();
  const std::size_t frame = second_->frame_at(time);
  if (!state_ || frame != frame_ || state_->field != drawing.field) {
    state_ = second_->frame(frame, drawing.field);
    frame_ = frame;
  }
  const auto name = [&](const QString& of, double shown) {
    return tr("%1, at %2%3")
        .arg(of)
        .arg(shown, 0, 'g', 5)
        .arg(second_->kind() == RunKind::kMotion ? tr(" s") : QString());
  };
  first_label_->setText(name(first_name_, time));
  label_->setText(name(QDir(QString::fromStdString(second_->directory())).dirName(), state_->time));
  if (first_->follow_colors(state_->field_values)) {
    drawing.automatic_range = false;
    drawing.range[0] = first_->color_low();
    drawing.range[1] = first_->color_high();
  }
  view_->show_state(state_);
  view_->set_drawing(drawing);  // draws the picture
}

}  // namespace tetraction::viewer
