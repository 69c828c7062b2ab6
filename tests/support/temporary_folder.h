#pragma once
/// \file
/// A folder for the files of one test.

#include "workflows/program/temporary_folder.h"

namespace trame::test {

using workflows::TemporaryFolder;

}  // namespace trame::test
