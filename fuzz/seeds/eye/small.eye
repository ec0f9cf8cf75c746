# position, axis, acceptance, focal offset
0.1 -0.2 0.3 0 0 1 0.0454 0.25
1,2,3,0.6,0,-0.8,1.5e-2,0
-1	+2 , 3 0 1e-3 0 6.2831 .5 # end
