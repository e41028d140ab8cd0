// The units in which the window shows numbers: fields, picture, charts, times. The scene keeps SI units.
#include <vtkActor2DCollection.h>
#include <vtkLookupTable.h>
#include <vtkRenderer.h>
#include <vtkScalarBarActor.h>

#include <QComboBox>
#include <QFile>
#include <QTemporaryDir>
#include <QToolTip>

#include "viewer/gui/body/color_bar.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

class Units : public WindowTest {
 protected:
  void TearDown() override {
    window_.reset();
    set_unit_system(UnitSystem::kPrefixes);
  }
  Settings settings() { return window_->simulation()->settings(); }
};

TEST_F(Units, FieldsAreTypedInThemAndTheSceneKeepsSi) {
  show(quiet_beam());
  show_entry("time");
  EXPECT_EQ(number_field("step")->text().toDouble(), settings().time.step);
  trigger("units_2");
  EXPECT_DOUBLE_EQ(number_field("step")->text().toDouble(), 1e3 * settings().time.step);
  EXPECT_TRUE(number_field("step")->toolTip().contains(QStringLiteral("in ms")));
  enter("step", "0.51");
  EXPECT_EQ(settings().time.step, 0.00051);
  EXPECT_EQ(number_field("step")->text(), QStringLiteral("0.51"));
  EXPECT_TRUE(menu_action(QStringLiteral("&Undo"))->text().contains(QStringLiteral("0.51 ms")));
  type(number_field("step"), "-3");
  wait(300);
  EXPECT_TRUE(reason("step").contains(QStringLiteral("above 0, in ms")))
      << reason("step").toStdString();
  QTest::keyClick(number_field("step"), Qt::Key_Escape);

  show_entry("material");
  enter("youngs_modulus", "5.1");
  EXPECT_EQ(settings().materials[0].youngs_modulus, 5.1e6);
  EXPECT_TRUE(find<QLabel>("facts")->text().contains(QStringLiteral("MPa")));
  window_->scene_panels()->add(QStringLiteral("force"), {nearest({1.2, 0.3, 0.3})});
  settle();
  trigger("units_3");
  show_entry("force");
  enter("vector", "12.5", 1);
  EXPECT_EQ(settings().loads.force[0].vector.y(), 1.25e-8);
  keep_picture("micrometres");

  const QTemporaryDir folder;
  const QString path = folder.filePath(QStringLiteral("saved.toml"));
  ASSERT_TRUE(window_->save_scene(path));
  QFile file(path);
  ASSERT_TRUE(file.open(QIODevice::ReadOnly));
  const QString text = QString::fromUtf8(file.readAll());
  EXPECT_TRUE(text.contains(QStringLiteral("0.00051"))) << text.toStdString();
  EXPECT_TRUE(text.contains(QStringLiteral("1.25e-08")) || text.contains(QStringLiteral("1.25e-8")))
      << text.toStdString();
  trigger("units_1");
  EXPECT_EQ(number_field("vector", 1)->text(), QStringLiteral("1.25e-08"));
}

TEST_F(Units, ADragBeginsAtAThousandthOfThem) {
  show(quiet_beam());
  trigger("units_2");
  window_->scene_panels()->add(QStringLiteral("pressure"), {});
  settle();
  show_entry("pressure");
  enter("value", "0");
  NumberField* field = number_field("value");
  drag(field, QPoint(10, 8), QPoint(80, 8));
  settle();
  EXPECT_GT(settings().loads.pressure[0].value, 1e3);
  EXPECT_LT(settings().loads.pressure[0].value, 1e6);
}

TEST_F(Units, TheColourBarHasThem) {
  const auto title = [](UnitSystem system, double most) {
    set_unit_system(system);
    vtkNew<vtkRenderer> renderer;
    ColorBar bar(renderer);
    DrawingSettings drawing;
    drawing.field = find_quantity("von_mises");
    drawing.automatic_range = false;
    drawing.range[1] = 2.0e6;
    bar.set(drawing, 1, 0.0);
    auto* actor = vtkScalarBarActor::SafeDownCast(renderer->GetActors2D()->GetLastItem());
    EXPECT_DOUBLE_EQ(vtkLookupTable::SafeDownCast(actor->GetLookupTable())->GetTableRange()[1],
                     most);
    return std::string(actor->GetTitle());
  };
  EXPECT_TRUE(title(UnitSystem::kPrefixes, 2.0).ends_with("[MPa]"));
  EXPECT_TRUE(title(UnitSystem::kMetres, 2e6).ends_with("[Pa]"));
  EXPECT_TRUE(title(UnitSystem::kMillimetres, 2.0).ends_with("[MPa]"));
  EXPECT_TRUE(title(UnitSystem::kMicrometres, 2000.0).ends_with("[kPa]"));
}

TEST_F(Units, TheRangeOfTheColoursIsTypedInThem) {
  show(quiet_beam());
  raise("dock_drawing");
  auto* field = find<QComboBox>("color_field");
  field->setFocus();
  field->setCurrentIndex(field->findText(QStringLiteral("von Mises stress [Pa]")) - 1);
  QTest::keyClick(field, Qt::Key_Down);
  ASSERT_TRUE(field->currentText().startsWith(QStringLiteral("von Mises")))
      << field->currentText().toStdString();
  trigger("units_2");
  EXPECT_TRUE(field->currentText().endsWith(QStringLiteral("[MPa]")));
  type(find<NumberField>("range_high"), "2.5");
  EXPECT_EQ(window_->body_view()->color_high(), 2.5e6);
  trigger("units_0");
  EXPECT_EQ(find<NumberField>("range_high")->text(), QStringLiteral("2.5e+06"));
}

TEST_F(Units, TimesChartsAndLengthsHaveThem) {
  show(falling_beam());
  trigger("units_2");
  run_to(0.05);
  EXPECT_EQ(window_->chart()->horizontal_title(), "Time [ms]");
  const QString time = find<QLabel>("time")->text();
  EXPECT_TRUE(time.endsWith(QStringLiteral(" ms"))) << time.toStdString();
  EXPECT_NEAR(time.section(QLatin1Char(' '), 0, 0).toDouble(), 1e3 * state().time, 0.1);
  window_->select({nearest({0.0, 0.0, 0.3}), nearest({0.0, 0.3, 0.3})});
  auto* measured = find<QLabel>("measure");
  EXPECT_TRUE(wait_for([&] { return measured->text().endsWith(QStringLiteral(": 300 mm")); }, 3000))
      << measured->text().toStdString();
  QWidget* chart = window_->chart()->canvas();
  QTest::mouseMove(chart, QPoint(chart->width() / 2, chart->height() / 2));
  EXPECT_TRUE(wait_for([] { return QToolTip::text().contains(QStringLiteral(" mJ")); }, 3000))
      << QToolTip::text().toStdString();
  EXPECT_TRUE(QToolTip::text().contains(QStringLiteral(" ms")));
  keep_picture("millimetres");

  // The next window has them, too.
  window_->close();
  open_window();
  EXPECT_TRUE(find<QAction>("units_2")->isChecked());
  EXPECT_EQ(window_->chart()->horizontal_title(), "Time [ms]");
}

}  // namespace
}  // namespace tetraction::viewer
