// A command of the program that the window starts, such as tetraction modes.
#pragma once

#include <QElapsedTimer>
#include <QObject>
#include <QProcess>
#include <QStringList>
#include <QTimer>

namespace tetraction::viewer {

/// The program tetraction beside this one, with one command at a time.
class Computation : public QObject {
  Q_OBJECT

 public:
  explicit Computation(QObject* parent = nullptr);
  /// Ends a command in progress.
  ~Computation() override;

  /// Starts a command with its arguments, whose results go to `directory`.
  void start(const QStringList& arguments, const QString& directory);
  bool is_running() const { return process_.state() != QProcess::NotRunning; }
  const QString& directory() const { return directory_; }
  /// What it warned of.
  const QStringList& warnings() const { return warnings_; }
  /// Asks the command to end, which writes what it has, and kills it if it does not.
  void cancel();
  /// Ends the command and waits for it.
  void end();

 signals:
  /// What the command told last, and for how long it has worked. Twice a second.
  void progressed(const QString& text);
  /// `failure` is what it said, or empty after success.
  void ended(const QString& failure, bool was_cancelled);

 private:
  void read();
  void finish();

  QProcess process_;
  QString directory_;
  QElapsedTimer since_start_;
  QTimer timer_;
  QString line_;     // that was told last
  QString message_;  // the last one that is no progress and no warning
  QStringList warnings_;
  bool cancelled_ = false;
};

}  // namespace tetraction::viewer
