inline void speak() { std::cout << "the layer check must find this"; }
