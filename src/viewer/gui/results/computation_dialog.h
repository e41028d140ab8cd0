// Asks for the options of a command that the window starts.
#pragma once

#include <QString>
#include <QStringList>
#include <optional>

class QWidget;

namespace tetraction::viewer {

enum class ComputationKind { kEquilibrium, kModes, kStudy };

struct ComputationRequest {
  QString directory;      ///< of the results
  QStringList arguments;  ///< the command and its options, without scene and directory
};

/// `directory`: what is proposed, without the ending that tells the kind. `end` of the scene, s. No value if the user
/// does not want it. The command checks what is entered.
std::optional<ComputationRequest> ask_computation(QWidget* parent, ComputationKind kind,
                                                  const QString& directory, double end);

}  // namespace tetraction::viewer
