<?xml version="1.0" encoding="UTF-8"?>
<tileset version="1.10" tiledversion="1.10.1" name="tiles" tilewidth="16" tileheight="16" tilecount="7" columns="7">
 <image source="tiles.png" width="112" height="16"/>
 <tile id="0" type="tile">
  <properties>
   <property name="terrain" value="grass"/>
  </properties>
 </tile>
 <tile id="1" type="tile">
  <properties>
   <property name="blocked" type="bool" value="true"/>
   <property name="terrain" value="rock"/>
  </properties>
 </tile>
 <tile id="2" type="tile">
  <properties>
   <property name="diagonal" propertytype="corner" value="nw"/>
   <property name="terrain" value="grass"/>
  </properties>
 </tile>
 <tile id="3" type="tile">
  <properties>
   <property name="diagonal" propertytype="corner" value="ne"/>
   <property name="terrain" value="grass"/>
  </properties>
 </tile>
 <tile id="4" type="tile">
  <properties>
   <property name="diagonal" propertytype="corner" value="sw"/>
   <property name="terrain" value="grass"/>
  </properties>
 </tile>
 <tile id="5" type="tile">
  <properties>
   <property name="diagonal" propertytype="corner" value="se"/>
   <property name="terrain" value="grass"/>
  </properties>
 </tile>
 <tile id="6" type="tile">
  <properties>
   <property name="terrain" value="sand"/>
  </properties>
 </tile>
</tileset>
