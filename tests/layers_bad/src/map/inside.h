// One violation: the inside of another room.
#include "backend/cpu/lanes.h"
