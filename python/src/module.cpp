#include "bindings.h"
#include "plumbline/error.h"
#include "plumbline/version.h"

PYBIND11_MODULE(_plumbline, m) {
  namespace py = pybind11;
  m.doc() = "Dense 3D reconstruction from depth images: what the package `plumbline` is made of.";
  static const py::exception<plumbline::Error> error(m, "Error", PyExc_RuntimeError);
  error.attr("__doc__") =
      "Bad input, a bad configuration, a device or a file that cannot be used: where, what is wrong, and what to do. "
      "Losing track is no error, but a status.";
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const plumbline::Error& e) {
      PyErr_SetString(error.ptr(), e.what());
    }
  });
  m.attr("__version__") = std::string(plumbline::version());
  plumbline::python::add_parameters(m);
  plumbline::python::add_values(m);
  plumbline::python::add_pipeline(m);
  plumbline::python::add_sequences(m);
  plumbline::python::add_measures(m);
}
