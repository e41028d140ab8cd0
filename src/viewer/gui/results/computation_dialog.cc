#include "computation_dialog.h"

#include <QCheckBox>
#include <QCoreApplication>
#include <QDialog>
#include <QDialogButtonBox>
#include <QFileDialog>
#include <QFileInfo>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QRegularExpression>
#include <QSpinBox>
#include <functional>
#include <vector>

#include "tetraction/dynamics/steppers/integrator.h"

namespace tetraction::viewer {
namespace {

QString tr(const char* text) {
  return QCoreApplication::translate("ComputationDialog", text);
}

QSpinBox* add_number(QFormLayout* form, const QString& title, const char* name, int usual) {
  auto* number = new QSpinBox;
  number->setObjectName(QLatin1String(name));
  number->setRange(1, 1000);
  number->setValue(usual);
  form->addRow(title, number);
  return number;
}

QLineEdit* add_text(QFormLayout* form, const QString& title, const char* name,
                    const QString& usual) {
  auto* text = new QLineEdit(usual);
  text->setObjectName(QLatin1String(name));
  form->addRow(title, text);
  return text;
}

// The path, with a number if there is something already.
QString new_folder(const QString& path) {
  QString folder = path;
  for (int number = 2; QFileInfo::exists(folder); ++number) {
    folder = QStringLiteral("%1-%2").arg(path).arg(number);
  }
  return folder;
}

QCheckBox* add_check(QFormLayout* form, const QString& title, const char* name, bool on = false) {
  auto* check = new QCheckBox(title);
  check->setObjectName(QLatin1String(name));
  check->setChecked(on);
  form->addRow(QString(), check);
  return check;
}

// Each of these adds the fields of a command, and returns what makes its arguments.
using Arguments = std::function<QStringList()>;

Arguments add_equilibrium(QFormLayout* form) {
  constexpr int kUsual = 10;
  QSpinBox* steps = add_number(form, tr("Load steps, at least"), "load_steps", kUsual);
  return [steps] {
    return QStringList{"static", QStringLiteral("--steps=%1").arg(steps->value())};
  };
}

Arguments add_modes(QFormLayout* form) {
  constexpr int kUsual = 10;
  QSpinBox* count = add_number(form, tr("Number of modes"), "mode_count", kUsual);
  QCheckBox* loaded =
      add_check(form, tr("About the equilibrium under the loads at t = 0"), "about_equilibrium");
  return [count, loaded] {
    QStringList arguments{"modes", QStringLiteral("--count=%1").arg(count->value())};
    if (loaded->isChecked()) arguments += QStringLiteral("--static");
    return arguments;
  };
}

Arguments add_study(QFormLayout* form, double end) {
  std::vector<QCheckBox*> rules;
  for (const std::string name : integrator_names()) {
    rules.push_back(add_check(form, QString::fromStdString(name), ("rule_" + name).c_str(), true));
  }
  form->setWidget(form->rowCount() - static_cast<int>(rules.size()), QFormLayout::LabelRole,
                  new QLabel(tr("Integrators")));
  QLineEdit* steps = add_text(form, tr("Steps"), "study_steps", {});
  steps->setPlaceholderText(tr("chosen by the program"));
  steps->setToolTip(
      tr("With commas between them, in s, in stability limits (4x) or in excited periods (0.02T); "
         "of one rule as verlet=5e-6,auto, with spaces between the rules"));
  QLineEdit* budget = add_text(form, tr("Time for what the program chooses"), "study_budget",
                               QStringLiteral("1min"));
  QLineEdit* time = add_text(form, tr("End of the runs [s]"), "study_end", QString::number(end));
  QCheckBox* plots = add_check(form, tr("Draw the plots of study.html"), "study_plots");
  return [=] {
    QStringList names;
    for (const QCheckBox* rule : rules) {
      if (rule->isChecked()) names += rule->text();
    }
    QStringList arguments{"study", "--frames=all", "--integrators=" + names.join(','),
                          "--budget=" + budget->text(), "--set=time.end=" + time->text()};
    static const QRegularExpression around_comma(QStringLiteral("\\s*,\\s*"));
    const QStringList lists = steps->text()
                                  .replace(around_comma, QStringLiteral(","))
                                  .split(QLatin1Char(' '), Qt::SkipEmptyParts);
    for (const QString& list : lists) arguments += "--steps=" + list;
    if (!plots->isChecked()) arguments += QStringLiteral("--no-plots");
    return arguments;
  };
}

}  // namespace

std::optional<ComputationRequest> ask_computation(QWidget* parent, ComputationKind kind,
                                                  const QString& directory, double end) {
  const auto k = static_cast<std::size_t>(kind);
  const QString titles[] = {tr("Equilibrium under the loads at t = 0"), tr("Natural modes"),
                            tr("Study of integrators and time steps")};
  const char* endings[] = {"-static", "-modes", "-study"};
  QDialog dialog(parent);
  dialog.setObjectName(QStringLiteral("computation_dialog"));
  dialog.setWindowTitle(titles[k]);
  auto* form = new QFormLayout(&dialog);
  const Arguments arguments = kind == ComputationKind::kEquilibrium ? add_equilibrium(form)
                              : kind == ComputationKind::kModes     ? add_modes(form)
                                                                    : add_study(form, end);
  auto* row = new QHBoxLayout;
  auto* folder = new QLineEdit(new_folder(directory + QLatin1String(endings[k])));
  folder->setObjectName(QStringLiteral("computation_folder"));
  folder->setMinimumWidth(320);
  folder->setToolTip(tr(
      "Earlier results of this kind in it are replaced; a study keeps runs that compute the same"));
  auto* choose = new QPushButton(QObject::tr("Choose…"));
  choose->setAutoDefault(false);
  row->addWidget(folder);
  row->addWidget(choose);
  form->addRow(tr("Folder of the results"), row);
  QObject::connect(choose, &QPushButton::clicked, &dialog, [&] {
    const QString chosen = QFileDialog::getExistingDirectory(&dialog, QString(), folder->text());
    if (!chosen.isEmpty()) folder->setText(chosen);
  });
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel);
  buttons->button(QDialogButtonBox::Ok)->setText(tr("Compute"));
  form->addRow(buttons);
  QObject::connect(buttons, &QDialogButtonBox::accepted, &dialog, &QDialog::accept);
  QObject::connect(buttons, &QDialogButtonBox::rejected, &dialog, &QDialog::reject);
  if (dialog.exec() != QDialog::Accepted || folder->text().isEmpty()) return std::nullopt;
  return ComputationRequest{folder->text(), arguments()};
}

}  // namespace tetraction::viewer
