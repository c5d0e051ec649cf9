// A comment may speak of x & 7.
inline int in_brick(int x) { return x & 7; }
inline int first_word(int brick) { return brick << 9; }
inline int allowed(int edge, int flags) { return edge << 3 | (flags & 3); }
