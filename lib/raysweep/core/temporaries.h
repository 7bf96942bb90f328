/// Temporary files and folders beside what they will become. They are known until they are moved or removed, so that
/// whatever ends the process can take them along. Any thread may call these.
#pragma once

#include <string>

namespace raysweep {

/// Makes an empty file in `folder` that only its owner may read and write, under a name that nobody can foresee. It
/// ends with `extension`, so that writers which choose a format by name can; a long one is left out.
/// @param descriptor is set to the open file, which the caller closes
/// @throw IoError, which does not name what it is for
std::string makeTemporaryFile(const std::string& folder, const std::string& extension, int& descriptor);

/// The same for a folder, with the permissions that new folders have.
std::string makeTemporaryFolder(const std::string& folder);

/// Renames a temporary, in place of a file that is there. @return 0 or the system's error
int moveTemporary(const std::string& temporary, const std::string& target);

/// Puts a temporary in place of the folder `target`, which becomes the temporary. If it fails both are as they were.
/// @return 0 or the system's error
int exchangeTemporary(const std::string& temporary, const std::string& target);

/// A folder with all that is in it. No error if it is not there.
void removeTemporary(const std::string& temporary);

/// Removes all, for good: whoever makes or moves one afterwards waits for the end of the process, which the caller is
/// about to bring about.
void removeTemporariesForGood();

}  // namespace raysweep
