// SPDX-License-Identifier: BSD-3-Clause
/** \file
 * load_plugin LIBRARY: loads a plugin as MRPT's programs do, twice, uses its class, unloads it and
 * loads it again. Knows nothing of this project but the name of the class.
 */
#include <mrpt/rtti/CObject.h>
#include <mrpt/system/os.h>

#include <cstdlib>
#include <iostream>
#include <string>

namespace {

/** Stops with a message unless something worked. */
void require(bool worked, const std::string& what, const std::string& why = "") {
  if (worked) return;
  std::cerr << what << (why.empty() ? "" : ": " + why) << "\n";
  std::exit(1);
}

void load(const std::string& library) {
  std::string why;
  require(mrpt::system::loadPluginModule(library, why), "cannot load", why);
}

/** A map from its class's name, as when a stream or a rawlog holds one. */
void createMap() {
  mrpt::rtti::registerAllPendingClasses();
  const auto* known = mrpt::rtti::findRegisteredClass("mrpt::maps::CProbOctoMap");
  require(known != nullptr, "the class is not registered");
  require(known->createObject() != nullptr, "the class makes no object");
}

}  // namespace

int main(int argc, char** argv) {
  require(argc == 2, "usage: load_plugin LIBRARY");
  const std::string library = argv[1];
  load(library);
  createMap();
  load(library);
  createMap();
  std::string why;
  require(mrpt::system::unloadPluginModule(library, why), "cannot unload", why);
  createMap();  // MRPT forgets no class: what it has registered must stay
  load(library);
  createMap();
  std::cout << "loaded\n";
}
