"""Files of MATLAB and of the open IT2-FLS toolbox."""

from __future__ import annotations

# tipper.fis of the Fuzzy Logic Toolbox, as its documentation describes it.
TIPPER = """\
[System]
Name='tipper'
Type='mamdani'
Version=2.0
NumInputs=2
NumOutputs=1
NumRules=3
AndMethod='min'
OrMethod='max'
ImpMethod='min'
AggMethod='max'
DefuzzMethod='centroid'

[Input1]
Name='service'
Range=[0 10]
NumMFs=3
MF1='poor':'gaussmf',[1.5 0]
MF2='good':'gaussmf',[1.5 5]
MF3='excellent':'gaussmf',[1.5 10]

[Input2]
Name='food'
Range=[0 10]
NumMFs=2
MF1='rancid':'trapmf',[-2 0 1 3]
MF2='delicious':'trapmf',[7 9 10 12]

% the tip in percent
[Output1]
Name='tip'
Range=[0 30]
NumMFs=3
MF1='cheap':'trimf',[0 5 10]
MF2='average':'trimf',[10 15 20]
MF3='generous':'trimf',[20 25 30]

[Rules]
1 1, 1 (1) : 2
2 0, 2 (1) : 1
3 2, 3 (1) : 2
"""


# The layout that the Fuzzy Logic Toolbox gives a sugfistype2.
TYPE2 = """\
[System]
Name='type2'
Type='sugeno'
Version=3.0
NumInputs=1
NumOutputs=1
NumRules=2
AndMethod='prod'
OrMethod='probor'
ImpMethod='prod'
AggMethod='sum'
DefuzzMethod='wtaver'
TypeReductionMethod='karnikmendel'

[Input1]
Name='e'
Range=[-1 1]
NumMFs=2
MF1='N':'trimf',[-1 -0.5 0.5],[0.8],[0.1 0.2]
MF2='P':'linsmf',[-0.5 0.5],[1],[0.25 0]

[Output1]
Name='u'
Range=[0 1]
NumMFs=2
MF1='low':'constant',[-1]
MF2='high':'linear',[2 1]

[Rules]
1, 1 (1) : 1
2, 2 (1) : 1
"""


# The layout of the open IT2-FLS toolbox.
OPEN_TYPE2 = """\
[System]
Name='open'
Type='sugeno'
Version=2.0
NumInputs=1
NumOutputs=1
NumRules=2
AndMethod='prod'
OrMethod='probor'
ImpMethod='prod'
AggMethod='sum'
DefuzzMethod='wtaver'
TypeRedMethod='Karnik-Mendel'
outputType='interval'

[Input1]
Name='input1'
Range=[-1 1]
NumMFs=2
MF1U='mf1U':'trapmf',[-1.8 -1 0 1 1]
MF1L='mf1L':'trimf',[-1.6 -0.5 0.3 0.3]
MF2U='x-N':'gaussmf',[0.4 1 1]
MF2L='mf2L':'gaussmf',[0.2 1 1]

[Output1]
Name='output1'
CrispInterval='interval'
Range=[-1 1]
NumMFs=2
MF1='mf1':'constant',[-1 -0.9]
MF2='mf2':'constant',[0.5]

[Rules]
1, 1 (1) : 1
2, 2 (1) : 1
"""


CROSSING = (
    OPEN_TYPE2.replace("TypeRedMethod='Karnik-Mendel'", "TypeRedMethod='NT'")
    .replace("'trapmf',[-1.8 -1 0 1 1]", "'trapmf',[-0.9 -0.5 0 0.5 1]")
    .replace("MF1='mf1':'constant',[-1 -0.9]", "MF1='mf1':'linear',[2 1 -1 0.5]")
)
"""The lower set of the first term is above the upper one where it begins, and again at the end."""
