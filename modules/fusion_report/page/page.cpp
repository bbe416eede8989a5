// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Puts the data of a run into the built page. */

#include "fusion_report/page/page.h"

#include <stdexcept>

#include "fusion_report/json.h"
#include "fusion_report/page/template.h"

namespace mrpt::fusion {
namespace {

constexpr std::string_view kBeginning = "<!doctype html>\n<!-- map-fusion page ";
constexpr std::string_view kData = "<!--DATA-->";

/** Returns JSON that cannot end its element or begin a comment. The characters that HTML knows
 * occur only within the strings of JSON. */
std::string inHtml(const std::string& json) {
  std::string text;
  text.reserve(json.size() + 64);
  for (const char c : json) switch (c) {
      case '<':
        text += "\\u003c";
        break;
      case '>':
        text += "\\u003e";
        break;
      case '&':
        text += "\\u0026";
        break;
      default:
        text += c;
    }
  return text;
}

std::string block(const char* id, const std::string& json) {
  return "<script type=\"application/json\" id=\"" + std::string(id) + "\">" + inHtml(json) +
         "</script>\n";
}

}  // namespace

std::string toPage(const Report& report, const std::string& scene_json) {
  const std::string_view page = pageTemplate();
  const size_t at = page.find(kData);
  if (at == std::string_view::npos) throw std::logic_error("the template has no place for data");
  std::string result(page.substr(0, at));
  result += block("report", toJson(report));
  result += block("scene", scene_json);
  result += page.substr(at + kData.size());
  return result;
}

bool isPage(std::string_view beginning) {
  return beginning.substr(0, kBeginning.size()) == kBeginning;
}

}  // namespace mrpt::fusion
