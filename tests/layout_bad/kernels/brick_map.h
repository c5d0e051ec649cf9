// The owner may: int index(int x) { return x >> 3 << 9 | (x & 7); }
inline int brick_index(int x) { return x >> 3; }
