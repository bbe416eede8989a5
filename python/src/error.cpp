// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The exception and the warnings of the module. */

#include <exception>
#include <new>

#include "bindings.h"
#include "fusion_base/error_text.h"

namespace mrpt_fusion_python {
namespace {

PyObject* error = nullptr;  // owned by the module, which is never unloaded

/** Returns a message, which may quote bytes of files that are not UTF-8, as a text. */
py::object textOf(const std::string& message) {
  return py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(message.data(), static_cast<Py_ssize_t>(message.size()), "replace"));
}

void raise(const std::exception& e) {
  PyErr_SetObject(error, textOf(mrpt::fusion::messageOf(e)).ptr());
}

}  // namespace

void warn(const std::string& text) {
  const auto message = textOf(text).cast<std::string>();
  if (PyErr_WarnEx(PyExc_UserWarning, message.c_str(), 1) < 0) throw py::error_already_set();
}

void bindError(py::module_& m) {
  error = PyErr_NewExceptionWithDoc(
      "mrpt_fusion.Error",
      "An input that cannot be used: a damaged file, a map without obstacles, an unknown option.\n"
      "The message is one line. It begins with the path if a file is the reason.\n\n"
      ">>> mf.load('missing.ot')\n"
      "Traceback (most recent call last):\n"
      "mrpt_fusion.Error: missing.ot: cannot be opened: No such file or directory",
      PyExc_RuntimeError, nullptr);
  if (!error) throw py::error_already_set();
  m.add_object("Error", error);
  py::register_local_exception_translator([](std::exception_ptr thrown) {
    try {
      std::rethrow_exception(thrown);
    } catch (const py::builtin_exception&) {
      throw;  // a TypeError or ValueError of Python
    } catch (const std::bad_alloc&) {
      throw;  // a MemoryError
    } catch (const std::exception& e) {
      raise(e);
    }
  });
}

}  // namespace mrpt_fusion_python
