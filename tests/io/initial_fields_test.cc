// Displacements and velocities of [initial] from files and formulas.
#include "tetraction/io/initial_fields.h"

#include <clocale>
#include <cmath>
#include <filesystem>
#include <locale>
#include <utility>

#include "io/text/csv_table.h"
#include "io/text/formula.h"
#include "support/folder_test.h"
#include "support/runs.h"
#include "tetraction/io/mesh_writer.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/scene_writer.h"

namespace tetraction {
namespace {

using namespace testing_support;

namespace fs = std::filesystem;

class InitialFields : public FolderTest {
 protected:
  // A scene of one tetrahedron with these lines in [initial].
  Scene scene(const std::string& initial,
              const std::string& mesh = "generate = { kind = \"tetrahedron\", size = 2 }") const {
    return read_scene(file("scene.toml", "[mesh]\n" + mesh +
                                             "\n[material]\nyoungs_modulus = 1e6\n" +
                                             "poissons_ratio = 0.3\n[initial]\n" + initial));
  }

  // The message about a displacement of one tetrahedron from a file.
  std::string file_error(const std::string& csv) const {
    file("u.csv", csv);
    const std::string message = message_of<FileError>(
        [&] { read_scene_mesh(scene("displacement = { file = \"u.csv\" }\n")); });
    if (message == "accepted") return message;
    EXPECT_EQ(message.rfind((folder_ / "u.csv").string(), 0), 0U) << message;
    return message.substr((folder_ / "u.csv").string().size());
  }

  std::string formula_error(const std::string& formula) const {
    return message_of([&] {
      read_scene_mesh(scene("velocity = { formula = [\"0\", \"" + formula + "\", \"0\"] }\n"));
    });
  }
};

TEST_F(InitialFields, FormulasAreEvaluatedAtTheRestPositions) {
  const Scene s = scene(
      "displacement = { formula = [\"0.1*X\", \"-Y^2/8\", \"X > 1 ? 0.25 : 0\"] }\n"
      "velocity = { formula = [\"1e-3\", \"sin(pi*Z/4)\", \"max(X, Y)\"] }\n");
  Session session(s, read_scene_mesh(s));
  const TetMesh& mesh = session.system().mesh();
  const State& state = session.state();
  for (Index v = 0; v < 4; ++v) {
    const Vector3 x = mesh.vertices[static_cast<std::size_t>(v)];
    const Vector3 u(0.1 * x[0], -x[1] * x[1] / 8, x[0] > 1 ? 0.25 : 0.0);
    const Vector3 w(1e-3, std::sin(3.14159265358979323846 * x[2] / 4), std::max(x[0], x[1]));
    EXPECT_LT((vertex_block(state.position, v) - x - u).norm(), 1e-15);
    EXPECT_LT((Vector3(state.velocity.segment<3>(3 * v)) - w).norm(), 1e-15);
  }
}

TEST_F(InitialFields, AVectorMovesTheWholeBody) {
  const Scene s = scene("displacement = [1, 2, 3]\nvelocity = [0, 0, 1]\n");
  EXPECT_TRUE(s.initial.displacement_field.empty());
  Session session(s, read_scene_mesh(s));
  for (Index v = 0; v < 4; ++v) {
    const Vector3 x = session.system().mesh().vertices[static_cast<std::size_t>(v)];
    EXPECT_EQ(Vector3(vertex_block(session.state().position, v)), Vector3(x + Vector3(1, 2, 3)));
  }
}

TEST_F(InitialFields, FilesOfEachForm) {
  const std::string rows[] = {"0.5,0,0", "0,0.25,0", "0,0,0.125", "1e-3,-2e-3,+3e-3"};
  const Matrix all =
      (Matrix(3, 4) << 0.5, 0, 0, 1e-3, 0, 0.25, 0, -2e-3, 0, 0, 0.125, 3e-3).finished();
  const auto field = [&](const std::string& csv) {
    file("u.csv", csv);
    return read_scene_mesh(scene("displacement = { file = \"u.csv\" }\n"))
        .point_arrays.at(kInitialDisplacement);
  };
  std::string plain;
  std::string numbered = "vertex,x,y,z\n";
  for (int v : {3, 0, 2, 1}) numbered += std::to_string(v) + "," + rows[v] + "\n";
  for (const std::string& row : rows) plain += row + "\n";
  EXPECT_EQ(field(plain), all);
  EXPECT_EQ(field("x,y,z\n" + plain), all);
  EXPECT_EQ(field(numbered), all);
  EXPECT_EQ(field("\xef\xbb\xbf vertex , x,y,\tz\r\n\r\n3, " + rows[3] + "\r\n"),
            (Matrix(3, 4) << 0, 0, 0, 1e-3, 0, 0, 0, -2e-3, 0, 0, 0, 3e-3).finished());
}

TEST_F(InitialFields, VertexNumbersAreThoseOfTheMeshFile) {
  TetMesh mesh = generate_tetrahedron(1.0);
  for (auto& id : mesh.vertex_ids) id = 10 * id + 7;
  write_mesh(mesh, (folder_ / "body.msh").string());
  file("v.csv", "27,1,2,3\n");
  const Scene s = scene("velocity = { file = \"v.csv\" }\n", "file = \"body.msh\"");
  const Matrix field = read_scene_mesh(s).point_arrays.at(kInitialVelocity);
  EXPECT_EQ(field, (Matrix(3, 4) << 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3, 0).finished());
}

TEST_F(InitialFields, BrokenFilesAreRefusedWithTheLine) {
  const auto expect = [this](const std::string& csv, const std::string& what) {
    const std::string message = file_error(csv);
    EXPECT_EQ(message.substr(0, what.size()), what) << message;
  };
  expect("vertex,x,y,z\n0,1,2,3\n0,1,2,3\n", ":3: vertex 0 is given a second time, after line 2.");
  expect("0,1,2,3\n\n4,1,2,3\n", ":3: the mesh has no vertex 4.");
  expect("0.5,1,2,3\n", ":1: the mesh has no vertex 0.5.");
  expect("1,2,3\n1,2,3\n",
         ":2: the file has 2 lines of three numbers, and the mesh has 4 vertices.");
  expect("1,2,3\n1,2\n", ":2: the line has 2 columns");
  expect("x;y;z\n0;0;0\n0,1;0,2;0,3\n",
         ":3: the line has semicolons and commas. If the commas are");
  expect("0,1;2,3\n", ":1: the line has semicolons and commas");
  expect("1,2,3\n1,2,x\n", ":2: \"x\" is not a finite number.");
  expect("1,2,3\n1,2,nan\n", ":2: \"nan\" is not a finite number.");
  expect("1,2,3\n1,2,1e999\n", ":2: \"1e999\" is not a finite number.");
  expect("1;2;3\n", ":1: the file has 1 lines of three");
  expect("x;y;z\n", ": the file has no line of numbers.");
  expect("1,2\n", ":1: the columns must be");
  expect("vertex,z,y,x\n0,1,2,3\n", ":1: the columns must be");
  expect("", ": the file has no line of numbers.");
  fs::remove(folder_ / "u.csv");
  EXPECT_THROW(read_scene_mesh(scene("displacement = { file = \"none.csv\" }\n")), FileError);
  EXPECT_THROW(read_scene_mesh(scene("displacement = { file = \".\" }\n")), FileError);
}

TEST_F(InitialFields, WrongFormulasAreRefusedWithKeyAndPosition) {
  const auto expect = [this](const std::string& formula, const std::string& what) {
    const std::string message = formula_error(formula);
    expect_part(message, "scene.toml:7:14: initial.velocity.formula: the formula of y, \"" +
                             formula + "\"" + what);
  };
  expect("0.1*Q", ", character 5: \"Q\" is not a variable");
  expect("X + ", ", character 5: the formula ends too early.");
  expect("(X", ", character 3: a closing parenthesis is missing.");
  expect("atan2(X)", "");
  expect("X = 3", ", character 3: a formula has no \"=\"");
  expect("1,5*X", ", character 2: a comma does not fit here.");
  expect("1/X", " is inf at vertex 0, X = 0");
  expect("sqrt(-1-X)", " is -nan at vertex 0");
  EXPECT_EQ(formula_error("X <= 1 && Y != 2 ? 1 : 0"), "accepted");
}

TEST_F(InitialFields, TablesThatAreNeitherFileNorFormulaAreRefused) {
  for (const char* wrong : {"{ }", "{ file = \"a\", formula = [\"1\", \"2\", \"3\"] }",
                            "{ formula = [\"1\", \"2\"] }", "{ formula = [\"1\", \"2\", \"\"] }",
                            "{ formula = \"X\" }", "{ fil = \"a\" }", "{ file = \"\" }"}) {
    expect_error([&] { scene(std::string("displacement = ") + wrong + "\n"); },
                 {"scene.toml:7:", "displacement"});
  }
}

TEST_F(InitialFields, TheWriterWritesThemBack) {
  file("u.csv", "0,1e-3,0,0\n");
  const Scene s = scene(
      "displacement = { file = \"u.csv\" }\n"
      "velocity = { formula = [\"X > 1 ? \\\"1\\\" : 0\", \"\\\\\", \"Z\"] }\n");
  fs::create_directories(folder_ / "below");
  const std::string copy = (folder_ / "below" / "copy.toml").string();
  write_scene(s, copy);
  const Scene read = read_scene(copy);
  EXPECT_EQ(fs::weakly_canonical(read.initial.displacement_field.file),
            fs::weakly_canonical(folder_ / "u.csv"));
  EXPECT_EQ(read.initial.velocity_field.formula, s.initial.velocity_field.formula);
  EXPECT_EQ(scene_text(read, folder_.string()), scene_text(s, folder_.string()));
  EXPECT_NE(s.echo.find("u.csv"), std::string::npos);
  EXPECT_NE(s.echo.find("\"formula\""), std::string::npos);
}

TEST_F(InitialFields, WhatInvertsAnElementIsNamedWithItsPlace) {
  const Scene s =
      scene("stretch = [1, 2, 1]\ndisplacement = { formula = [\"-2*X\", \"0\", \"0\"] }\n");
  const auto system = make_system(s, read_scene_mesh(s));
  EXPECT_EQ(message_of([&] { make_initial_state(s, *system); }),
            s.path + ":8:1: initial.displacement inverts element 0: make it smaller.");
}

TEST_F(InitialFields, AMeshWithoutTheFieldIsRefused) {
  const Scene s = scene("displacement = { formula = [\"0.1*X\", \"0\", \"0\"] }\n");
  expect_error([&] { Session session(s, generate_tetrahedron(2.0)); }, {"read_scene_mesh()"});
}

// Neither the C locale nor the C++ locale has an influence on numbers.
TEST_F(InitialFields, LocalesDoNotMatter) {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale(), new Comma));
  const char* c_locale = std::setlocale(LC_NUMERIC, "de_DE.UTF-8");
  file("u.csv", "0,0.5,1234.25,0\n");
  const Scene s = scene(
      "displacement = { file = \"u.csv\" }\nvelocity = { formula = [\"1.5*X\", \"1250.5\", \"0\"] "
      "}\n");
  const TetMesh mesh = read_scene_mesh(s);
  std::locale::global(before);
  std::setlocale(LC_NUMERIC, "C");
  static_cast<void>(c_locale);
  EXPECT_EQ(mesh.point_arrays.at(kInitialDisplacement)(1, 0), 1234.25);
  EXPECT_EQ(mesh.point_arrays.at(kInitialVelocity)(0, 1), 3.0);
  EXPECT_EQ(mesh.point_arrays.at(kInitialVelocity)(1, 0), 1250.5);
}

TEST(Formula, HasTheFunctionsThatTheDocumentsName) {
  const auto value = [](const std::string& text, double x) { return Formula(text, {"X"})({x}); };
  EXPECT_EQ(value("X^2 + 3*X - 1", 2.0), 9.0);
  EXPECT_NEAR(value("ln(X)", 2.0), std::log(2.0), 1e-15);
  EXPECT_NEAR(value("log(X)", 2.0), std::log(2.0), 1e-15);
  EXPECT_NEAR(value("log10(X)", 100.0), 2.0, 1e-15);
  EXPECT_NEAR(value("atan2(X, 1)", 1.0), 0.25 * 3.14159265358979323846, 1e-15);
  EXPECT_EQ(value("min(X, 1, 3) + sign(-X) + abs(-2)", 2.0), 2.0);
  EXPECT_EQ(value("X == 2 ? 5 : 6", 2.0), 5.0);
  for (const char* name : {"sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh",
                           "asinh", "exp", "sqrt", "log2", "rint", "log"}) {
    EXPECT_TRUE(std::isfinite(value(std::string(name) + "(X)", 0.5))) << name;
  }
}

}  // namespace
}  // namespace tetraction
