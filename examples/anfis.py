"""ANFIS: rules learn to predict a series, and are printed as text."""

import numpy as np

import fuzzy2

time = np.arange(700)
series = np.sin(0.2 * time + np.sin(0.05 * time))
inputs, target = fuzzy2.lagged(series, lags=[18, 12, 6, 0], horizon=6)

model = fuzzy2.ANFIS(n_terms=2, most_epochs=10).fit(inputs[:400], target[:400])
predicted = model.predict(inputs[400:])
error = np.sqrt(np.mean((predicted - target[400:]) ** 2))
print(f"{len(model.system_.rules)} rules, off by {100 * error / target.std():.2f} % of the spread")
print(model.system_.explain(inputs[400]))

np.savetxt("prediction.csv", np.column_stack([target[400:], predicted]), delimiter=",")
fuzzy2.save(model.system_, "predictor.json")
print("prediction.csv, predictor.json")
