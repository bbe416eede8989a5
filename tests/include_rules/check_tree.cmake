# SPDX-License-Identifier: BSD-3-Clause
# Makes TREE of one FILE whose second line is LINE, runs CHECK on it, and fails unless CHECK prints
# FINDING and exits with 1, or, without FINDING, prints nothing and exits with 0.
file(REMOVE_RECURSE ${TREE})
file(WRITE ${TREE}/${FILE} "// a comment\n${LINE}\n")
execute_process(COMMAND ${CHECK} ${TREE}
  RESULT_VARIABLE code OUTPUT_VARIABLE printed ERROR_VARIABLE error)
if(FINDING STREQUAL "")
  set(expected_code 0)
  set(expected "")
else()
  set(expected_code 1)
  set(expected "${FINDING}\n")
endif()
if(NOT code STREQUAL "${expected_code}" OR NOT printed STREQUAL "${expected}")
  message(FATAL_ERROR "exit code ${code}, expected ${expected_code}\n"
    "printed: ${printed}\nexpected: ${expected}\n${error}")
endif()
