#include "section_form.h"

#include <QFormLayout>
#include <nlohmann/json.hpp>

#include "panel_layout.h"
#include "viewer/gui/widgets/number_field.h"

namespace tetraction::viewer {

SectionForm::SectionForm(const SceneSection& section, QFormLayout* form, QObject* parent)
    : QObject(parent) {
  for (const SceneKey& key : section.keys) {
    if (!(key.info.usual > 0.0)) continue;
    const QString title = tr(key.info.title);
    const QString unit = QString::fromUtf8(key.info.unit);
    auto* slider = new NumberSlider(key.info, 0.0, key.info.usual, NumberSlider::Scale::kLinear,
                                    form->parentWidget());
    slider->setObjectName(QString::fromUtf8(key.info.name));
    form->addRow(unit.isEmpty() ? title : tr("%1 [%2]").arg(title, unit), slider);
    connect(slider, &NumberSlider::entered, this,
            [this, title, unit](double value, bool continues_previous) {
              emit edited(
                  QStringLiteral("%1 %2 %3").arg(title, short_number(value), unit).trimmed(),
                  continues_previous);
            });
    connect(slider, &NumberSlider::refused, this, &SectionForm::refused);
    rows_.push_back({&key, slider});
  }
}

void SectionForm::show_settings(const void* settings) {
  for (const Row& row : rows_) row.slider->set_value(row.key->value->json(settings).get<double>());
}

void SectionForm::read(void* settings) const {
  for (const Row& row : rows_) {
    const Refusal refuse{[&row] { return std::string(row.key->info.name); }};
    row.key->value->read(row.slider->value(), row.key->info.range, refuse, settings);
  }
}

}  // namespace tetraction::viewer
