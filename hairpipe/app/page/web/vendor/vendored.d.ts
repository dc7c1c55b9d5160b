// What the page uses of scripts that are not ours.
declare const dagre: any;
declare const uPlot: any;
