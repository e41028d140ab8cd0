// The material of a scene, and the models that a scene can name.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tetraction/material/material_field.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

struct MaterialSettings {
  std::string model = "neo-hookean";
  // Either the model's own parameters, kParameters, or Young's modulus and Poisson's ratio together with its
  // kBesideYoung (MaterialChoice::instead).
  std::optional<double> youngs_modulus;
  std::optional<double> poissons_ratio;
  /// All other parameters by name, as "lambda" or "c10". The entries of a list are "mu.0", "mu.1", ….
  std::map<std::string, double> numbers{};
  std::optional<VolumetricPart> volumetric;  ///< only of models that have this choice
  double density = 1000.0;                   ///< kg/m³
  /// Set by a program, never by a scene file. If there is one, model and moduli are ignored.
  std::optional<MaterialModel> custom = std::nullopt;
  /// Parameters that a cell array of the mesh file gives, and perhaps "density": the name of the
  /// parameter and the name of the array. The members above hold no number for such a parameter;
  /// the number of the density is ignored.
  std::map<std::string, std::string> arrays{};
  std::string where{};  ///< place in the scene, for messages about the values of arrays
};

/// The parameters of all models, each once, in the order of the scene's documents. A name may be that of a number
/// and, for another model, of a list: there is one entry for each.
const std::vector<MaterialParameter>& material_parameters();
/// The parameter, or entry `i` of one that is a list, as a parameter of its own, such as "mu.0".
MaterialParameter entry_of(const MaterialParameter& parameter, int i);
/// The value of a parameter or of an entry of a list. No value if there is none or if an array gives it.
std::optional<double> number_of(const MaterialSettings& settings, const std::string& parameter);
void set_number(MaterialSettings& settings, const std::string& parameter, double value);

/// A model that a scene can name.
struct MaterialChoice {
  const char* name;
  const char* title;  ///< for people
  bool has_volumetric_part;
  std::vector<MaterialParameter> parameters;
  /// The parameters that can be given instead: Young's modulus, Poisson's ratio and `beside_young`, unless the
  /// model has other ones.
  std::vector<MaterialParameter> instead;
  std::vector<MaterialParameter> beside_young;
  bool defined_for_any_jacobian;  ///< whether Ψ is also defined for J ≤ 0
  /// Gives the parameters of a usual material with these small-strain parameters. Other settings stay.
  void (*set_like)(MaterialSettings& settings, const LameParameters& lame);
};
const std::vector<MaterialChoice>& material_choices();
/// The model of that name; null if there is none.
const MaterialChoice* find_material(const std::string& name);

/// The material of the settings. Throws InputError for unknown models, parameters that are missing,
/// do not belong to the model or contradict each other, values out of range, and parameters that an
/// array gives.
MaterialModel make_material(const MaterialSettings& settings);
/// The same for settings whose arrays are cell arrays of the mesh. The arrays are read at
/// `elements`, the tetrahedra that have this material. Throws InputError as above; and for an array
/// that the mesh does not have or that has more than one number for each tetrahedron, and for values
/// out of range, with the number of the tetrahedron.
MaterialField make_material(const MaterialSettings& settings, const TetMesh& mesh,
                            const std::vector<Index>& elements);
/// The densities that an array gives, one for each tetrahedron of the mesh; those that do not belong
/// to `elements` are 0. Empty if the density is one number. Throws InputError as above.
std::vector<double> make_densities(const MaterialSettings& settings, const TetMesh& mesh,
                                   const std::vector<Index>& elements);
/// Throws InputError for settings that make_material() would refuse with any mesh.
void check_material(const MaterialSettings& settings);

}  // namespace tetraction
