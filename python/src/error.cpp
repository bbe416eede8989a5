// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * The exception of the module. */

#include <exception>
#include <new>

#include "bindings.h"
#include "fusion_base/error_text.h"

namespace mrpt_fusion_python {
namespace {

PyObject* error = nullptr;  // owned by the module, which is never unloaded

/** Messages may quote bytes of files that are not UTF-8. */
void raise(const std::exception& e) {
  const std::string text = mrpt::fusion::messageOf(e);
  const auto message = py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "replace"));
  PyErr_SetObject(error, message.ptr());
}

}  // namespace

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
