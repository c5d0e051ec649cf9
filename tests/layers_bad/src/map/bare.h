// One violation: an include without its folder.
#include "volume.h"
