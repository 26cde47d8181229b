// The same million spheres for POV-Ray 3.7.
#version 3.7;
global_settings { assumed_gamma 1 }
camera { location <50, 60, 40> look_at <50, 0, -50> }
#declare Clay = texture { pigment { rgb <0.8, 0.5, 0.3> } finish { ambient 0 diffuse 1 } };
#for (I, 0, 999)
  #for (J, 0, 999)
    sphere { <I * 0.1, sin(I * 0.05) * sin(J * 0.05), -J * 0.1>, 0.02 + 0.01 * mod(I + J, 3)
      texture { Clay } }
  #end
#end
light_source { <50, 80, 0> rgb 1 }
