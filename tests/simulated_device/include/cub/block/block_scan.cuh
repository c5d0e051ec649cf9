#include "simulated_device/runtime.h"
