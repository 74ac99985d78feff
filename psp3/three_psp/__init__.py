"""The 3-PSP: parameters, geometry, closed form, workspace and compiled steps."""
