// One violation: a public header reaches into the library.
#include "kernels/lane.h"
