// What the shared library shows: everything else in it is hidden.
#pragma once

/// Of every public function and class whose code is in the library.
#if defined(__GNUC__)
#define PLUMBLINE_EXPORT __attribute__((visibility("default")))
#else
#define PLUMBLINE_EXPORT
#endif
