# SPDX-License-Identifier: BSD-3-Clause
# cmake -DPAGE=page.html -DOUT=template.cpp -P embed.cmake: writes the bytes of the page as C++.
file(READ "${PAGE}" bytes HEX)
string(REGEX REPLACE "(................................)" "\\1\n" bytes "${bytes}")
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
file(WRITE "${OUT}" "// Written by embed.cmake from page.html.
#include \"fusion_report/page/template.h\"

namespace mrpt::fusion {
namespace {
constexpr unsigned char kBytes[] = {
${bytes}};
}
std::string_view pageTemplate() {
  return {reinterpret_cast<const char*>(kBytes), sizeof(kBytes)};
}
}  // namespace mrpt::fusion
")
