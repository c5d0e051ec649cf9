// Parameters as attributes, from the list in plumbline/parameters.h.
#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <type_traits>

#include "bindings.h"
#include "plumbline/config.h"
#include "plumbline/parameters.h"

namespace plumbline::python {
namespace {

std::string number(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

std::string doc_of(std::string_view unit, std::string_view help, const Range& range) {
  std::string doc(help);
  if (!unit.empty()) doc += "; " + std::string(unit);
  if (std::isfinite(range.low)) doc += "; from " + number(range.low) + " to " + number(range.high);
  return doc;
}

/// As Python has it: an enumeration by its name.
template <class T>
auto to_python(const T& value) {
  if constexpr (std::is_enum_v<T>)
    return std::string(names(value)[static_cast<std::size_t>(value)]);
  else
    return value;
}

/// As a setting has it; its own error says what else it may be.
std::string setting_text(const py::handle& value) {
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
  if (py::isinstance<py::sequence>(value) || py::isinstance<py::array>(value)) {
    std::string text;
    for (const py::handle item : value) text += (text.empty() ? "" : ", ") + setting_text(item);
    return "[" + text + "]";
  }
  if (py::hasattr(value, "item")) return setting_text(value.attr("item")());  // a number of NumPy
  return py::str(value);
}

/// What `fields` calls for each member of a group: a property of the group's class.
template <class Group>
struct Properties {
  py::class_<Group>& type;
  const Group& prototype;
  Group Parameters::*member;
  std::string group;

  template <class T>
  void operator()(const char* name, const T& value, std::string_view unit, std::string_view help, const Range& range) {
    const auto offset = reinterpret_cast<const char*>(&value) - reinterpret_cast<const char*>(&prototype);
    const auto get = [offset](const Group& self) {
      return to_python(*reinterpret_cast<const T*>(reinterpret_cast<const char*>(&self) + offset));
    };
    const auto set = [key = group + "." + name + "=", at = member](Group& self, const py::object& given) {
      Parameters parameters;
      parameters.*at = self;
      apply_setting(key + setting_text(given), &parameters);
      self = parameters.*at;
    };
    const std::string doc = doc_of(unit, help, range);
    type.def_property(name, get, set, doc.c_str());
    // What is a word of the language is an attribute with an underscore, too: `orientation.lambda_`.
    if (py::module_::import("keyword").attr("iskeyword")(name).cast<bool>())
      type.def_property((std::string(name) + "_").c_str(), get, set, doc.c_str());
  }
};

template <class Group, class Fields>
void add_group(py::module_& m, py::class_<Parameters>& parameters, Group Parameters::*member, const char* name,
               const char* type_name, const Fields& fields_of) {
  py::class_<Group> type(m, type_name, (std::string("The group `") + name + "` of Parameters.").c_str());
  const Group prototype;
  fields_of(prototype, Properties<Group>{type, prototype, member, name});
  parameters.def_property(
      name, [member](Parameters& self) -> Group& { return self.*member; },
      [member](Parameters& self, const Group& group) { self.*member = group; },
      py::return_value_policy::reference_internal);
}

Parameters make(const std::string& name, const std::optional<std::string>& quality) {
  Parameters parameters = preset(name);
  if (quality) apply_quality(*quality, &parameters);
  return parameters;
}

void add_groups(py::module_& m, py::class_<Parameters>& type) {
  add_group(m, type, &Parameters::preprocess, "preprocess", "PreprocessParameters",
            [](const auto& p, auto&& v) { preprocess_fields(p, v); });
  add_group(m, type, &Parameters::tracking, "tracking", "TrackingParameters",
            [](const auto& p, auto&& v) { tracking_fields(p, v); });
  add_group(m, type, &Parameters::orientation, "orientation", "OrientationParameters",
            [](const auto& p, auto&& v) { orientation_fields(p, v); });
  add_group(m, type, &Parameters::motion, "motion", "MotionParameters",
            [](const auto& p, auto&& v) { motion_fields(p, v); });
  add_group(m, type, &Parameters::volume, "volume", "VolumeParameters",
            [](const auto& p, auto&& v) { volume_fields(p, v); });
  add_group(m, type, &Parameters::mesh, "mesh", "MeshParameters", [](const auto& p, auto&& v) { mesh_fields(p, v); });
}

}  // namespace

void add_parameters(py::module_& m) {
  py::class_<Parameters> type(
      m, "Parameters",
      "Every parameter of the reconstruction, in groups: `p.tracking.normal_gate = 25`. A value "
      "of another type or out of range raises Error, which says what is permitted.");
  add_groups(m, type);
  type.def(py::init(&make), py::arg("preset") = "plumbline", py::kw_only(), py::arg("quality") = py::none(),
           "A preset (plumbline, paper, kinectfusion), for plumbline also a quality (fast, balanced, best).")
      .def_static(
          "load",
          [](const Path& path) {
            Parameters parameters;
            load_parameters(path.string(), &parameters);
            return parameters;
          },
          py::arg("path"), "The preset plumbline, overlaid with what a TOML file names, such as a run's config.toml.")
      .def(
          "set", [](Parameters& self, const std::string& setting) { apply_setting(setting, &self); },
          py::arg("setting"), "One setting as on the command line: \"tracking.normal_gate=25\".")
      .def("validate", &validate, "Raises Error if two values contradict each other.")
      .def("to_toml", &to_toml, "TOML text that `load` reads back, with unit and help of each value.")
      .def_static("keys", &parameter_keys, "Every key, as \"group.name\".")
      .def(
          "copy", [](const Parameters& self) { return self; }, "Independent of this one.")
      .def("__copy__", [](const Parameters& self) { return self; })
      .def("__deepcopy__", [](const Parameters& self, const py::dict&) { return self; })
      .def("__eq__", [](const Parameters& self, const Parameters& other) { return to_toml(self) == to_toml(other); })
      .def("__repr__", [](const Parameters& self) { return "<plumbline.Parameters\n" + to_toml(self) + ">"; })
      .def(py::pickle([](const Parameters& self) { return to_toml(self); },
                      [](const std::string& text) {
                        Parameters parameters;
                        parse_parameters(text, "pickled parameters", &parameters);
                        return parameters;
                      }));
  type.attr("__hash__") = py::none();
  m.def("presets", &preset_names, "Names that Parameters takes.");
  m.def("qualities", &quality_names, "Names that Parameters takes as `quality`.");
}

}  // namespace plumbline::python
