#include "io/upwards.h"  // the layer check must find this
