#include "computation.h"

#include <QCoreApplication>
#include <QDir>

namespace tetraction::viewer {
namespace {

constexpr int kPatience_ms = 3000;  // until a command that was asked to end is killed
constexpr int kProgress_ms = 500;

const QString kOwnWord = QStringLiteral("tetraction: ");
const QString kWarning = kOwnWord + QStringLiteral("warning: ");

}  // namespace

Computation::Computation(QObject* parent) : QObject(parent) {
  process_.setStandardInputFile(QProcess::nullDevice());
  process_.setStandardOutputFile(QProcess::nullDevice());
  process_.setReadChannel(QProcess::StandardError);
  connect(&process_, &QProcess::readyReadStandardError, this, &Computation::read);
  connect(&process_, QOverload<int, QProcess::ExitStatus>::of(&QProcess::finished), this,
          &Computation::finish);
  connect(&process_, &QProcess::errorOccurred, this, [this](QProcess::ProcessError error) {
    if (error != QProcess::FailedToStart) return;  // finished() follows
    timer_.stop();
    emit ended(tr("%1 cannot be started. Is the program installed beside the window's?")
                   .arg(process_.program()),
               false);
  });
  connect(&timer_, &QTimer::timeout, this, [this] {
    const QString seconds = tr("%1 s").arg(since_start_.elapsed() / 1000);
    emit progressed(line_.isEmpty() ? seconds : tr("%1, %2").arg(line_, seconds));
  });
}

Computation::~Computation() {
  end();
}

void Computation::end() {
  process_.disconnect(this);
  timer_.stop();
  if (!is_running()) return;
  process_.terminate();
  if (!process_.waitForFinished(kPatience_ms)) {
    process_.kill();
    process_.waitForFinished(kPatience_ms);
  }
}

void Computation::start(const QStringList& arguments, const QString& directory) {
  directory_ = directory;
  line_.clear();
  message_.clear();
  warnings_.clear();
  cancelled_ = false;
  since_start_.start();
  timer_.start(kProgress_ms);
  const QDir own(QCoreApplication::applicationDirPath());
  process_.start(own.filePath(QStringLiteral("tetraction")), arguments);
}

void Computation::cancel() {
  if (!is_running()) return;
  cancelled_ = true;
  process_.terminate();
  QTimer::singleShot(kPatience_ms, &process_, [this, id = process_.processId()] {
    if (is_running() && process_.processId() == id) process_.kill();
  });
}

void Computation::read() {
  while (process_.canReadLine()) {
    const QString line = QString::fromUtf8(process_.readLine()).trimmed();
    if (line.startsWith(kWarning)) {
      warnings_ += line.mid(kWarning.size());
    } else if (line.startsWith(kOwnWord)) {
      message_ = line.mid(kOwnWord.size());
    } else if (!line.isEmpty()) {
      line_ = line;
    }
  }
}

void Computation::finish() {
  timer_.stop();
  read();
  const bool good = process_.exitStatus() == QProcess::NormalExit && process_.exitCode() == 0;
  if (!good && message_.isEmpty()) message_ = tr("It ended without a message.");
  emit ended(good ? QString() : message_, cancelled_);
}

}  // namespace tetraction::viewer
