int slots(int bricks) { return bricks * bricks; }
int first_voxel(int brick) { return brick * kBrickSide; }
