// Times fuzzylite's engine of a file on rows of inputs: main FILE.fll ROUNDS < rows.
//
// Prints the nanoseconds of processor time that a call takes, and then the outputs of each row.
#include <fl/Headers.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <memory>
#include <vector>

int main(int, char **words)
{
    const std::unique_ptr<fl::Engine> engine(fl::FllImporter().fromFile(words[1]));
    const long rounds = std::atol(words[2]);
    const std::size_t inputs = engine->numberOfInputVariables();
    std::vector<double> rows;
    for (double number; std::cin >> number;) {
        rows.push_back(number);
    }
    const std::size_t count = rows.size() / inputs;
    double sum = 0.0;
    const std::clock_t start = std::clock();
    for (long round = 0; round < rounds; round++) {
        for (std::size_t row = 0; row < count; row++) {
            for (std::size_t i = 0; i < inputs; i++) {
                engine->getInputVariable(i)->setValue(rows[row * inputs + i]);
            }
            engine->process();
            sum += engine->getOutputVariable(0)->getValue();
        }
    }
    std::printf("%.17g\n", static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC * 1e9
                               / (static_cast<double>(rounds) * static_cast<double>(count)));
    for (std::size_t row = 0; row < count; row++) {
        for (std::size_t i = 0; i < inputs; i++) {
            engine->getInputVariable(i)->setValue(rows[row * inputs + i]);
        }
        engine->process();
        for (std::size_t j = 0; j < engine->numberOfOutputVariables(); j++) {
            std::printf("%.17g ", engine->getOutputVariable(j)->getValue());
        }
        std::printf("\n");
    }
    return sum == 0.123;
}
