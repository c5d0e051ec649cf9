__global__ void kernel();  // the layer check must find this
