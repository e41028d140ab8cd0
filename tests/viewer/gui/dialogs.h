// What a person does with a dialog, which keeps the test waiting while it is open.
#pragma once

#include <QApplication>
#include <QDialog>
#include <QFileDialog>
#include <QLineEdit>
#include <QTimer>
#include <QtTest/QTest>
#include <functional>

namespace tetraction::viewer {

/// For the next dialog, to be made before what opens it. A dialog that is open for long is closed, so
/// that a test fails rather than hangs.
class DialogAnswer {
 public:
  /// `act` is done again for as long as the dialog is open.
  explicit DialogAnswer(std::function<void(QDialog&)> act) : act_(std::move(act)) {
    QObject::connect(&timer_, &QTimer::timeout, [this] { look(); });
    timer_.start(kLook_ms);
  }
  /// Enters a path and accepts it, as often as it takes: the dialog reads the folder meanwhile. What is
  /// asked beside it is accepted as proposed.
  static DialogAnswer path(const QString& path) {
    return DialogAnswer([path](QDialog& dialog) {
      auto* name = dialog.findChild<QLineEdit*>(QStringLiteral("fileNameEdit"));
      if (name == nullptr) return dialog.accept();
      // At once, as from the clipboard, and without a list of proposals: a dialog that reads folders in
      // another thread has ideas of its own about half a path.
      name->setCompleter(nullptr);
      name->setText(path);
      QTest::keyClick(name, Qt::Key_Return);
    });
  }
  /// Whether there was a dialog.
  bool given() const { return given_; }
  /// Whether it had to be closed by force.
  bool stuck() const { return stuck_; }

 private:
  static constexpr int kLook_ms = 50;
  static constexpr int kPatience = 100;  // looks

  void look() {
    auto* dialog = qobject_cast<QDialog*>(QApplication::activeModalWidget());
    if (dialog == nullptr) return;
    if (++looks_ > kPatience) {
      stuck_ = true;
      dialog->reject();
    } else {
      given_ = true;
      act_(*dialog);
    }
  }

  std::function<void(QDialog&)> act_;
  QTimer timer_;
  int looks_ = 0;
  bool given_ = false;
  bool stuck_ = false;
};

}  // namespace tetraction::viewer
