"""
Formations of a group: shapes, references, assignment of slots, switching and repair.

Pure functions of what one vehicle knows (thesis Sections 1.7.2 and 1.10). A *slot* is a place in the shape,
numbered from 0; the leader may fly in any of them. The frame of the shape has its origin at the path point, x
along the course, y to its right and z down.
"""
