#include "comparison.h"

#include <QDir>
#include <QLabel>
#include <QPainter>
#include <QVBoxLayout>
#include <algorithm>
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

// The middle of a picture, scaled such that it fills the size.
QImage filling(const QImage& picture, const QSize& size) {
  if (picture.size() == size) return picture;
  const QImage scaled =
      picture.scaled(size, Qt::KeepAspectRatioByExpanding, Qt::SmoothTransformation);
  return scaled.copy(QRect(
      QPoint((scaled.width() - size.width()) / 2, (scaled.height() - size.height()) / 2), size));
}

QImage picture_of(BodyView* view, const QSize& size) {
  return size.isEmpty() ? view->picture() : filling(view->picture(size), size);
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
  shape_ = std::move(shape);
  view_->set_body(shape_);
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

void Comparison::set_recording(bool on) {
  first_->set_recording(on);
  if (view_ != nullptr) view_->set_recording(on);
}

QImage Comparison::picture(const QSize& size) {
  if (view_ == nullptr) return picture_of(first_, size);
  constexpr int kTextsOfHeight = 32;  // of a picture of another size
  constexpr int kGap = 2;
  const int text = size.isEmpty() ? static_cast<int>(label_->height() * label_->devicePixelRatioF())
                                  : size.height() / kTextsOfHeight;
  const int left = (size.width() - kGap) / 2;
  const QSize room(0, text);
  QImage first = picture_of(first_, size.isEmpty() ? size : QSize(left, size.height()) - room);
  QImage second = picture_of(
      view_, size.isEmpty() ? size : QSize(size.width() - kGap - left, size.height()) - room);
  for (QImage* picture : {&first, &second}) picture->setDevicePixelRatio(1.0);
  QImage both(first.width() + kGap + second.width(),
              std::max(first.height(), second.height()) + text, QImage::Format_RGB32);
  both.fill(palette().color(QPalette::Window));
  QPainter painter(&both);
  QFont face = font();
  face.setPixelSize(std::max(text * 6 / 10, 1));
  painter.setFont(face);
  painter.setPen(palette().color(QPalette::WindowText));
  int x = 0;
  for (const auto& [picture, label] :
       {std::pair(&first, first_label_), std::pair(&second, label_)}) {
    painter.drawImage(x, 0, *picture);
    painter.drawText(QRect(x, both.height() - text, picture->width(), text), Qt::AlignCenter,
                     label->text());
    x += picture->width() + kGap;
  }
  return both;
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
  const auto strained = [this] { return is_strained(*shape_, state_->position); };
  if (first_->follow_colors(state_->field_values, strained)) {
    drawing.automatic_range = false;
    drawing.range[0] = first_->color_low();
    drawing.range[1] = first_->color_high();
  }
  view_->show_state(state_);
  view_->set_drawing(drawing);  // draws the picture
}

}  // namespace tetraction::viewer
