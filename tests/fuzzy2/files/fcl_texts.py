"""A file of the Fuzzy Control Language."""

from __future__ import annotations

BRAKE = """\
(* Two blocks; this comment
   goes on *)
Function_Block brake
VAR_INPUT  speed : REAL; gap : REAL;  END_VAR   // one line
VAR_OUTPUT force : REAL; horn : REAL; plan : REAL; END_VAR
FUZZIFY speed
  TERM low  := (0, 1) (40, 0);
  TERM high := (20, 0) (60, 1);
END_FUZZIFY
fuzzify gap
  RANGE := (0 .. 100);
  TERM near := trian 0 0 50;
  TERM far := GBELL 20 3 100;
END_FUZZIFY
DEFUZZIFY force
  TERM weak := (0, 0) (10, 1) (20, 0);
  TERM strong := TRAPE 10 20 30 30;
  METHOD : COG;  DEFAULT := 0;
END_DEFUZZIFY
DEFUZZIFY horn
  TERM silent := 0;
  TERM loud := 8;
  METHOD : COGS; DEFAULT := NC;
END_DEFUZZIFY
DEFUZZIFY plan
  TERM slow := FUNCTION (speed * 0.5) - 2*gap + 1;
  TERM keep := FUNCTION speed;
  METHOD : COGF;
END_DEFUZZIFY
RULEBLOCK first
  AND : PROD;  ACT : MIN;  ACCU : MAX; /* OR follows */
  RULE 1 : IF Speed IS LOW OR gap IS far THEN Force IS weak, horn IS silent, plan IS keep;
  RULE 2 : IF speed IS high AND NOT (gap IS far) THEN force IS strong AND horn IS loud
           WITH 0.5;
  RULE 3 : IF speed IS NOT low AND gap IS near THEN horn IS loud;
  RULE 4 : IF speed IS high THEN plan IS slow;
END_RULEBLOCK
END_FUNCTION_BLOCK

FUNCTION_BLOCK other
VAR_INPUT x : REAL; END_VAR
VAR_OUTPUT y : REAL; END_VAR
FUZZIFY x TERM a := GAUSS 0 1; END_FUZZIFY
DEFUZZIFY y TERM b := (0,0) (1,1); METHOD : RM; END_DEFUZZIFY
RULEBLOCK n  RULE 1 : IF x IS a THEN y IS b;  END_RULEBLOCK
END_FUNCTION_BLOCK
"""
