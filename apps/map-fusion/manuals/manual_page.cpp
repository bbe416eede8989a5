// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * Manual pages. */

#include <algorithm>
#include <cctype>
#include <sstream>

#include "manuals/manuals.h"

namespace map_fusion {
namespace {

/** Returns text as troff prints it. */
std::string escaped(const std::string& text) {
  std::string out;
  bool begins_line = true;
  for (const char c : text) {
    if (begins_line && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if (c == '\'')
      out += "\\(aq";
    else
      out += c;
    begins_line = c == '\n';
  }
  return out;
}

std::string bold(const std::string& text) { return "\\fB" + escaped(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + escaped(text) + "\\fR"; }

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

/** Returns the first sentence of a description, as a part of the line in NAME. */
std::string summaryOf(const CLI::App& app) {
  std::string text = app.get_description();
  std::replace(text.begin(), text.end(), '\n', ' ');
  text = text.substr(0, std::min(text.find(". "), text.find(": ")));
  if (!text.empty() && text.back() == '.') text.pop_back();
  if (!text.empty()) text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
  return text;
}

std::string header(const std::string& name, const CLI::App& app) {
  return ".TH " + escaped(upper(name)) +
         " 1 \"\" \"mrpt\\-fusion " MAP_FUSION_VERSION "\" \"User Commands\"\n.SH NAME\n" +
         escaped(name) + " \\- " + escaped(summaryOf(app)) + "\n";
}

/** Returns a list of options as a sentence. */
std::string relation(const std::string& verb, const std::set<CLI::Option*>& options) {
  std::string text;
  for (const CLI::Option* option : options)
    text += (text.empty() ? " " + verb + " " : ", ") + option->get_name();
  return text.empty() ? text : text + ".";
}

std::string entryOf(const CLI::Option& option) {
  std::ostringstream out;
  out << ".TP\n";
  std::string separator;
  for (const auto& name : option.get_snames()) {
    out << separator << bold("-" + name);
    separator = ", ";
  }
  for (const auto& name : option.get_lnames()) {
    out << separator << bold("--" + name);
    separator = ", ";
  }
  if (const std::string value = valueOf(option); !value.empty()) out << " " << italic(value);
  std::string text = option.get_description();
  if (!text.empty() && text.back() != '.') text += '.';
  if (option.get_required()) text += " Required.";
  if (!option.get_default_str().empty()) text += " Default: " + option.get_default_str() + ".";
  text += relation("Needs", option.get_needs()) + relation("Not with", option.get_excludes());
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  out << "\n" << escaped(text) << "\n";
  return out.str();
}

std::string optionsOf(const CLI::App& app) {
  std::string text;
  for (const auto* option : app.get_options())
    if (!option->get_positional()) text += entryOf(*option);
  return ".SH OPTIONS\n" + text;
}

std::string exitStatus(const CLI::App& app) {
  return ".SH EXIT STATUS\n" + escaped(app.get_footer()) + "\n";
}

}  // namespace

std::vector<const CLI::App*> commandsOf(const CLI::App& app) {
  return app.get_subcommands(nullptr);
}

std::vector<std::string> wordsOf(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const size_t begin = type.find('{'), end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos) return {};
  return CLI::detail::split(type.substr(begin + 1, end - begin - 1), ',');
}

std::string valueOf(const CLI::Option& option) {
  // CLI11 joins the type and the checks of an option: "FLOAT:M", "TEXT:{average,bayes}".
  if (option.get_items_expected_max() == 0) return {};
  const std::string type = option.get_type_name();
  if (const auto words = wordsOf(option); !words.empty()) return CLI::detail::join(words, "|");
  const size_t colon = type.find(':');
  const std::string name = type.substr(0, colon);
  const bool is_general = name == "TEXT" || name == "FLOAT" || name == "UINT";
  if (!is_general || colon == std::string::npos) return name;
  const std::string check = type.substr(colon + 1);
  return check == "POSITIVE" ? "N" : check;
}

std::string manualPage(const CLI::App& app) {
  std::ostringstream out;
  out << header("map-fusion", app) << ".SH SYNOPSIS\n"
      << bold("map-fusion") << " " << italic("COMMAND") << " [" << italic("OPTIONS") << "] "
      << italic("FILES") << "\n.SH DESCRIPTION\n"
      << escaped(app.get_description()) << "\n.SH COMMANDS\n";
  for (const CLI::App* command : commandsOf(app))
    out << ".TP\n"
        << bold(command->get_name()) << "\n"
        << escaped(command->get_description()) << ". See "
        << bold("map-fusion-" + command->get_name()) << "(1).\n";
  out << optionsOf(app) << exitStatus(app);
  return out.str();
}

std::string manualPage(const CLI::App& app, const CLI::App& command) {
  const std::string name = "map-fusion-" + command.get_name();
  std::ostringstream out;
  std::string arguments, names;
  for (const auto* option : command.get_options())
    if (option->get_positional()) {
      names += " " + italic(option->get_name(true));
      arguments += ".TP\n" + italic(option->get_name(true)) + "\n" +
                   escaped(option->get_description()) + "\n";
    }
  out << header(name, command) << ".SH SYNOPSIS\n"
      << bold("map-fusion " + command.get_name()) << " [" << italic("OPTIONS") << "]" << names
      << "\n.SH DESCRIPTION\n"
      << escaped(command.get_description()) << ".\n"
      << (arguments.empty() ? "" : ".SH ARGUMENTS\n") << arguments << optionsOf(command);
  std::string example = command.get_footer();
  example.erase(0, example.find('\n') + 1);  // the line "Example:"
  out << ".SH EXAMPLE\n.nf\n.RS\n" << escaped(example) << "\n.RE\n.fi\n" << exitStatus(app);
  out << ".SH SEE ALSO\n" << bold("map-fusion") << "(1)\n";
  return out.str();
}

}  // namespace map_fusion
