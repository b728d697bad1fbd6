"""The frame of a report: the order of its sections."""

from __future__ import annotations

from string import Template

PAGE = Template("""\
$head
<body>
<h1>$title</h1>
<p class="facts">$facts</p>
<p>$flown</p>
<h2>Result</h2>
<ul class="verdicts">
$verdicts
</ul>
$figures
<h2>Numbers</h2>
<div class="scroll">
$numbers
</div>
<h2>Repeat it</h2>
$again
<h2>Made with</h2>
<div class="scroll">
$versions
</div>
<details><summary>The resolved scenario</summary>
<pre>$scenario</pre>
</details>
</body>
</html>
""")
